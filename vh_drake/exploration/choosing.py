"""Where to touch next and on which way, from the estimate alone."""

import dataclasses as dc

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vh_drake.errors import UnknownName
from vh_drake.exploration.bulges import bulge
from vh_drake.exploration.detour import way_around
from vh_drake.exploration.explorer import ExplorerSettings, Known
from vh_drake.exploration.strategies import Facing, Situation
from vh_drake.gpis.following import Sheet, follow_surface
from vh_drake.gpis.posterior import Posterior
from vh_drake.types import Array, Immutable, IntArray

DEPARTURES = ["contact_normal", "inverse_velocity"]

_BATCH = 16  # curves that are checked at once
_AROUND_M = 0.03  # how far a way around keeps off all that is known
_LEG_M = 0.05  # of the straight end of a way around that has to be free
_ASIDE_AT_LAST_M = 0.005  # around targets set aside, once nothing is fresh
_MOST_MARGIN_M = 0.05  # to which the margin grows
_WHOLE_M = 0.5  # a candidate radius from which on the whole surface is taken
_CHECKED = np.linspace(0.1, 0.9, 9)[:, None]  # places of a curve that have to be free
_BERNSTEIN = np.hstack(
    [
        (1 - _CHECKED) ** 3,
        3 * _CHECKED * (1 - _CHECKED) ** 2,
        3 * _CHECKED**2 * (1 - _CHECKED),
        _CHECKED**3,
    ]
)
_GOLDEN = np.pi * (1 + 5**0.5)


def _even_directions(count: int) -> Array:
    """Unit vectors (count, 3) spread over the sphere along a spiral."""
    i = np.arange(count) + 0.5
    z = 1.0 - 2.0 * i / count
    r = np.sqrt(1.0 - z * z)
    return np.column_stack([r * np.cos(_GOLDEN * i), r * np.sin(_GOLDEN * i), z])


_DIRECTIONS = _even_directions(100)


@dc.dataclass(frozen=True, eq=False)
class Choice(Immutable):
    """The candidates of a step, and which of them shall be touched how."""

    p: Array  # (m, 3) [m]
    n: Array  # (m, 3) outward normals
    rating: Array  # (m,) by the strategy
    chosen: int
    curves: Array  # (k, 4, 3) control points of the way, one after the other [m]


def choose_touch(known: Known, settings: ExplorerSettings, *, seed: int) -> Choice | None:
    """The next touch; None where the estimate offers nothing.

    The best rated candidate is taken whose curve keeps off the estimate. Where there is none, and
    after barren touches in a row, one away from here is reached by a way around the object instead.
    Where nothing is fresh any more, places that face as no contact nearby does are touched whatever
    the strategy is, each on a way from outside along its normal: the estimate closes over what it
    does not know, and whatever sticks out there stands in this way.

    Args:
        known: so far.
        settings: strategy and limits.
        seed: of choices by chance.

    Raises:
        UnknownName: the departure rule.
    """
    stuck = known.barren >= settings.most_barren
    situation, fresh = _candidates(known, settings, seed, anywhere=stuck)
    if len(situation.p) == 0:
        return None
    rating = (settings.strategy if fresh else Facing()).rate(situation)
    order = np.argsort(-rating, kind="stable")
    if fresh and not stuck:
        for start in range(0, len(order), _BATCH):
            batch = order[start : start + _BATCH]
            curves = situation.curves_to(batch)
            free = _free(known.posterior, curves, settings)
            if free.any():
                i = int(np.argmax(free))
                return Choice(situation.p, situation.n, rating, int(batch[i]), curves[i : i + 1])
    best = _reachable_from_outside(situation, order, settings)
    tried = max(known.barren - settings.most_barren, 0)
    way = _way_around(situation, best, settings, tried)
    return Choice(situation.p, situation.n, rating, best, way)


def candidates(known: Known, settings: ExplorerSettings, *, seed: int = 0) -> Situation:
    """What a strategy would rate now.

    Raises:
        UnknownName: the departure rule.
    """
    return _candidates(known, settings, seed, anywhere=False)[0]


def departure_direction(known: Known, rule: str) -> Array:
    """Unit direction (3,) in which the fingertip leaves its last contact.

    Raises:
        UnknownName: the rule.
    """
    if rule not in DEPARTURES:
        raise UnknownName("departure", rule, DEPARTURES)
    normal: Array = known.contacts.n_WC[-1]
    return normal if rule == "contact_normal" else -known.arrival_W


def _candidates(
    known: Known, s: ExplorerSettings, seed: int, *, anywhere: bool
) -> tuple[Situation, bool]:
    """The candidates, and whether some are unexplored."""
    sheet, chosen, fresh = _offered(known, s, anywhere=anywhere)
    return situation_at(sheet.vertices[chosen], sheet.normals[chosen], known, s, seed), fresh


def situation_at(p: Array, n: Array, known: Known, s: ExplorerSettings, seed: int) -> Situation:
    """What a strategy rates where p (m, 3) [m], with normals n (m, 3), can be touched.

    Raises:
        UnknownName: the departure rule.
    """
    return Situation(
        p=p,
        n=n,
        contacts=known.contacts,
        posterior=known.posterior,
        p_WTip=known.p_WTip,
        departure_W=departure_direction(known, s.departure),
        approach_W=known.approach_W,
        tip_radius_m=s.tip_radius_m,
        explored_radius_m=s.explored_radius_m,
        seed=seed,
    )


def _offered(
    known: Known, s: ExplorerSettings, *, anywhere: bool
) -> tuple[Sheet, NDArray[np.bool_], bool]:
    """An estimate, which of its vertices are candidates, and whether some of it is unexplored.

    The radius grows until some of it is and does not bulge, then the margin does: an estimate that
    ends within its margin seems explored, though the object may go on. What is explored is offered
    only where something near it is not.
    """
    least = max(s.fresh_m, s.explored_radius_m)
    radius, margin = np.inf if anywhere else s.candidate_radius_m, s.margin_m
    offered_m = s.fresh_m
    while True:
        sheet = _sheet(known, s, radius, margin)
        allowed = _allowed(sheet.vertices, known, s, s.set_aside_m, anywhere=anywhere)
        away = cKDTree(known.contacts.p_WC).query(sheet.vertices)[0]
        low = bulge(sheet.vertices, known.contacts, within_m=s.bulge_within_m) <= s.bulge_m
        unexplored = allowed & (away >= least)
        if (unexplored & low).any() or (radius == np.inf and margin >= _MOST_MARGIN_M):
            break
        if radius == np.inf:
            margin = min(2.0 * margin, _MOST_MARGIN_M)
        radius, offered_m = 2.0 * radius if 2.0 * radius < _WHOLE_M else np.inf, least
    likely = allowed & (away >= offered_m) & low
    rest = _allowed(sheet.vertices, known, s, _ASIDE_AT_LAST_M, anywhere=anywhere)
    if (unexplored & low).any():
        return sheet, likely, True
    chosen = next((some for some in (unexplored, rest) if some.any()), ~rest)
    return sheet, chosen, bool(unexplored.any())


def _sheet(known: Known, s: ExplorerSettings, radius: float, margin: float) -> Sheet:
    """The estimate within a radius of the last contact and a margin of all of them."""
    p = known.contacts.p_WC
    low, high = p.min(axis=0) - margin, p.max(axis=0) + margin
    if radius > float(np.linalg.norm(high - low)):
        return follow_surface(known.posterior, p, spacing_m=s.spacing_m, margin_m=margin)
    sheet = follow_surface(known.posterior, p[-1:], spacing_m=s.spacing_m, margin_m=radius)
    kept = ((sheet.vertices >= low) & (sheet.vertices <= high)).all(axis=1)
    kept &= np.linalg.norm(sheet.vertices - p[-1], axis=1) <= radius
    return Sheet(sheet.vertices[kept], sheet.normals[kept])


def _allowed(
    p: Array, known: Known, s: ExplorerSettings, aside_m: float, *, anywhere: bool
) -> NDArray[np.bool_]:
    """Places away from targets that led to barren touches; away from here if `anywhere`."""
    allowed = np.ones(len(p), bool)
    if len(known.set_aside):
        allowed = np.asarray(cKDTree(known.set_aside).query(p)[0] >= aside_m)
    return _elsewhere(allowed, p, known, s) if anywhere else allowed


def _elsewhere(
    allowed: NDArray[np.bool_], p: Array, known: Known, s: ExplorerSettings
) -> NDArray[np.bool_]:
    """Allowed candidates away from the last contact, farther with each barren touch more.

    All that are allowed where none is so far away.
    """
    leave = s.leave_m * (1 + known.barren - s.most_barren)
    there = allowed & (np.linalg.norm(p - known.contacts.p_WC[-1], axis=1) > leave)
    return there if there.any() else allowed


def _free(posterior: Posterior, curves: Array, s: ExplorerSettings) -> NDArray[np.bool_]:
    """Which curves (k, 4, 3) of the tip's centre keep off the estimate (k,)."""
    p = _BERNSTEIN @ curves  # (k, 9, 3)
    potential = posterior.mean(p.reshape(-1, 3)).reshape(p.shape[:2])
    return np.asarray(potential.min(axis=1) > s.clearance_m)


def _reachable_from_outside(s: Situation, order: IntArray, settings: ExplorerSettings) -> int:
    """The first candidate that can be touched straight against its normal, else the first."""
    shares = np.array([1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0])[:, None]
    for start in range(0, len(order), _BATCH):
        batch = order[start : start + _BATCH]
        n = s.n[batch][:, None]
        legs = s.p[batch][:, None] + (s.tip_radius_m + _LEG_M * shares) * n
        free = _free(s.posterior, legs, settings)
        if free.any():
            return int(batch[int(np.argmax(free))])
    return int(order[0])


def _way_around(s: Situation, chosen: int, settings: ExplorerSettings, tried: int) -> Array:
    """Curves that lead to a candidate around all contacts, out by another way than those tried."""
    p_to = s.p[chosen] + s.tip_radius_m * s.n[chosen]
    known = np.vstack([s.contacts.p_WC, s.p_WTip, p_to])
    center = 0.5 * (known.min(axis=0) + known.max(axis=0))
    radius = float(np.linalg.norm(known - center, axis=1).max()) + _AROUND_M
    leave = _way_out(s, radius, settings, tried)
    return way_around(s.p_WTip, leave, p_to, s.n[chosen], center=center, radius_m=radius)


def _way_out(s: Situation, reach_m: float, settings: ExplorerSettings, tried: int) -> Array:
    """The direction (3,) out of a cavity: off all contacts around, best where nothing is expected.

    Where contacts lie on two sides, the departure from the last one leads to the other. After so
    many directions were tried in vain the next one is taken.
    """
    p, n = s.contacts.p_WC, s.contacts.n_WC
    near = np.linalg.norm(p - p[-1], axis=1) < settings.cavity_m
    around = n[near & (np.einsum("ij,ij->i", s.p_WTip - p, n) > 0.0)]
    directions = np.vstack([s.departure_W, _DIRECTIONS])
    off = (directions @ around.T).min(axis=1)
    directions = directions[np.argsort(-off, kind="stable")]
    way = np.arange(s.tip_radius_m, reach_m, s.tip_radius_m)
    places = s.p_WTip + way[:, None] * directions[:, None]
    least = s.posterior.mean(places.reshape(-1, 3)).reshape(places.shape[:2]).min(axis=1)
    free = (least > settings.clearance_m) & (np.sort(off)[::-1] > 0.1)
    open_ways = np.flatnonzero(free) if free.any() else np.arange(len(directions))
    direction: Array = directions[open_ways[tried % len(open_ways)]]
    return direction
