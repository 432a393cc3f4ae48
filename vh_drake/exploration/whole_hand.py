"""Exploration by a whole hand: one closing touches with several fingertips (section 5.2).

A hand pose is planned on the estimate, so that the fingertips would explore the most there; the
hand comes along its approach until it touches, closes, and every fingertip that touches gives a
contact. How a hand closes is none of this module's business: it asks a `Closer`, one for the
estimate and one for the truth.

Where closings teach nothing, as in narrow cavities, one finger touches alone, like any explorer.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.exploration.coverage import Coverage
from vh_drake.exploration.explorer import Arrival, ExplorerSettings, Known, after_touch
from vh_drake.exploration.loop import Body, EndSettings, begin, touches
from vh_drake.gpis.following import Sheet, follow_surface
from vh_drake.types import Array, Immutable


@dc.dataclass(frozen=True, eq=False)
class HandContacts(Immutable):
    """Where the fingertips of a closed hand touch."""

    p_WC: Array = dc.field(default_factory=lambda: np.zeros((0, 3)))  # (c, 3) [m]
    n_WC: Array = dc.field(default_factory=lambda: np.zeros((0, 3)))  # (c, 3) outward normals


# Closes the hand from a pose X_WH (4, 4), after it went along an approach, a unit vector (3,) in
# H, until it touched.
Closer = Callable[[Array, Array], HandContacts]


@dc.dataclass(frozen=True, eq=False)
class HandAim(Immutable):
    """How a hand is brought to a surface, in its base frame H."""

    approaches: Array  # (a, 3) unit vectors along which it comes
    along: Array  # (3,) unit vector from wrist to fingertips
    places: Array  # (b, 3) which of its places come over the target [m]


@dc.dataclass(frozen=True)
class WholeHandSettings:
    """How poses are searched."""

    targets: int = 6  # on the estimate
    rolls: int = 4  # about the approach
    back_off_m: float = 0.15  # from where the hand comes
    trust_m: float = 0.03  # as in `LookAhead`
    most_barren: int = 2  # closings in a row that taught nothing, after which one finger touches


@dc.dataclass(frozen=True, eq=False)
class Hand(Immutable):
    """A hand as planning knows it."""

    closer_on: Callable[[Sheet], Closer]  # makes what closes it on an estimate
    aim: HandAim
    search: WholeHandSettings = dc.field(default_factory=WholeHandSettings)


@dc.dataclass(frozen=True, eq=False)
class HandMotion(Immutable):
    """One motion of the hand."""

    closing: bool  # else a touch by one finger
    contacts: int
    share: float  # explored afterwards


@dc.dataclass(frozen=True, eq=False)
class HandExploration(Immutable):
    """A whole exploration; the first contact is one fingertip's, as everywhere."""

    known: Known
    share: float  # explored in the end
    motions: tuple[HandMotion, ...]
    end: str  # "goal", "stuck" or "lost"


@dc.dataclass(frozen=True, eq=False)
class HandPlan(Immutable):
    """A pose from which the hand shall approach and close."""

    X_WH: Array  # (4, 4), backed off
    approach_H: Array  # (3,)
    expected: HandContacts  # on the estimate


@dc.dataclass(frozen=True, eq=False)
class _State(Immutable):
    """Between two motions."""

    known: Known
    coverage: Coverage
    barren: int  # closings in a row
    written_off: Array  # (k, 3) places that barren closings expected to touch [m]


def explore_by_hand(
    body: Body,
    truth: Closer,
    hand: Hand,
    settings: ExplorerSettings,
    end: EndSettings | None = None,
    *,
    seed: int = 0,
) -> HandExploration:
    """Explore a body by closings until enough is explored or nothing is gained any more.

    Args:
        body: the object.
        truth: closes the hand on it.
        hand: as planning knows it.
        settings: of the estimate, and of touches by one finger.
        end: when it ends.
        seed: of the first approach.

    Raises:
        BadInput: no straight way to the centre meets the object.
    """
    end = end or EndSettings()
    state = _State(*begin(body, settings, seed=seed), 0, np.zeros((0, 3)))
    motions: list[HandMotion] = []
    without_gain, reason = 0, "goal"
    while state.coverage.share < end.goal:
        if without_gain >= end.most_without_gain or len(motions) >= end.most_touches:
            reason = "stuck"
            break
        moved = _moved(state, body, truth, hand, settings, seed)
        if moved is None:
            reason = "lost"
            break
        share = state.coverage.share
        state, motion = moved
        motions.append(motion)
        without_gain = 0 if motion.share > share else without_gain + 1
    return HandExploration(state.known, state.coverage.share, tuple(motions), reason)


def _moved(
    state: _State, body: Body, truth: Closer, hand: Hand, settings: ExplorerSettings, seed: int
) -> tuple[_State, HandMotion] | None:
    """One motion: a closing, or after barren ones a touch by one finger."""
    plan = None
    if state.barren < hand.search.most_barren:
        plan = plan_closing(state.known, hand, settings, state.written_off)
    if plan is None:
        step = next(touches(body, state.known, state.coverage, settings, seed=seed), None)
        if step is None:
            return None
        touched = _State(step.known, step.coverage, 0, state.written_off)
        return touched, HandMotion(False, 1, step.coverage.share)
    found = truth(plan.X_WH, plan.approach_H)
    coverage, barren, written_off = state.coverage, 0, state.written_off
    if not _far_from(found.p_WC, state.known.contacts.p_WC, settings.barren_m).any():
        barren = state.barren + 1
        written_off = np.vstack([written_off, plan.expected.p_WC])
    for p in found.p_WC:
        coverage = coverage.with_contact(p)
    known = after_closing(state.known, found, settings)
    closed = _State(known, coverage, barren, written_off)
    return closed, HandMotion(True, len(found.p_WC), coverage.share)


def plan_closing(
    known: Known, hand: Hand, settings: ExplorerSettings, written_off: Array
) -> HandPlan | None:
    """The closing whose fingertips would explore most of the estimate; None where none does.

    Args:
        known: so far.
        hand: how it closes and comes.
        settings: of the estimate.
        written_off: (k, 3) places that closings expected to touch in vain [m].
    """
    p = known.contacts.p_WC
    sheet = follow_surface(
        known.posterior, p, spacing_m=settings.spacing_m, margin_m=settings.margin_m
    )
    if len(sheet.vertices) == 0:
        return None
    beyond = cKDTree(p).query(sheet.vertices)[0] - settings.explored_radius_m
    weight = np.where(beyond > 0.0, np.exp(-beyond / hand.search.trust_m), 0.0)
    if len(written_off):
        weight[cKDTree(written_off).query(sheet.vertices)[0] < settings.set_aside_m] = 0.0
    close, tree = hand.closer_on(sheet), cKDTree(sheet.vertices)
    best, found = 0.0, None
    for target in _targets(sheet.vertices, weight, hand.search.targets):
        p_WT, n_WT = sheet.vertices[target], sheet.normals[target]
        for X_WH, approach in poses(p_WT, n_WT, hand.aim, hand.search):
            contacts = close(X_WH, approach)
            near = tree.query_ball_point(contacts.p_WC, settings.explored_radius_m)
            gain = float(weight[sorted(set().union(*near))].sum()) if len(near) else 0.0
            if gain > best:
                best, found = gain, HandPlan(X_WH, approach, contacts)
    return found


def poses(p: Array, n: Array, aim: HandAim, hand: WholeHandSettings) -> list[tuple[Array, Array]]:
    """Start poses (4, 4) and approaches (3,) that bring a hand against a normal n over a place p.

    For each approach and place of the hand it turns about the normal in even steps.
    """
    side = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    side /= np.linalg.norm(side)
    found = []
    for approach in aim.approaches:
        along = aim.along - (aim.along @ approach) * approach
        along /= np.linalg.norm(along)
        in_hand = np.column_stack([approach, along, np.cross(approach, along)])
        for angle in 2.0 * np.pi * np.arange(hand.rolls) / hand.rolls:
            forward = np.cos(angle) * side + np.sin(angle) * np.cross(n, side)
            R_WH = np.column_stack([-n, forward, np.cross(-n, forward)]) @ in_hand.T
            for place in aim.places:
                X_WH = np.eye(4)
                X_WH[:3, :3] = R_WH
                X_WH[:3, 3] = p - R_WH @ place + hand.back_off_m * n
                found.append((X_WH, approach))
    return found


def after_closing(known: Known, found: HandContacts, settings: ExplorerSettings) -> Known:
    """What is known after a closing; contacts nearer than `least_apart_m` to others are dropped.

    Raises:
        IllConditionedKernel: the kernel can't hold the contacts.
    """
    for p, n in zip(found.p_WC, found.n_WC, strict=True):
        if not _far_from(p[None], known.contacts.p_WC, settings.least_apart_m)[0]:
            continue
        arrival = Arrival(p + settings.tip_radius_m * n, -n, -n, p, n)
        more = after_touch(known, p, arrival, settings)
        known = dc.replace(more, set_aside=known.set_aside, barren=0)
    return known


def _targets(p: Array, weight: Array, count: int) -> list[int]:
    """Indices of points p (v, 3) that are worth exploring: the best, then each far from the last.

    Weights are (v,); none is chosen where all of them are zero.
    """
    open_ = np.flatnonzero(weight > 0.0)
    if len(open_) == 0:
        return []
    chosen = [int(open_[np.argmax(weight[open_])])]
    gap = np.linalg.norm(p[open_] - p[chosen[0]], axis=1)
    while len(chosen) < min(count, len(open_)):
        chosen.append(int(open_[np.argmax(gap)]))
        gap = np.minimum(gap, np.linalg.norm(p[open_] - p[chosen[-1]], axis=1))
    return chosen


def _far_from(p: Array, q: Array, least_m: float) -> Array:
    """Which of the points p (c, 3) are at least so far from all points q (k, 3)."""
    return np.asarray(cKDTree(q).query(p)[0] >= least_m) if len(p) else np.zeros(0, bool)
