r"""An explorer that stops by itself, from the estimate alone, at a wanted accuracy (section 5.2).

It touches in rounds, each finer than the one before: a round is over once hardly any of the
estimate is farther than its radius from all contacts. After every touch it bounds the error of the
surface, the symmetric mean distance between estimate and truth, by

.. math:: \log \hat e = w_0 + w_1 \log s + w_2 \log (b + b_0), \quad \bar e = q \hat e

with what it knows itself: how far off the estimate was, in the mean of the last touches, where it
was touched (s, the potential that the new contact had before), and the share b of the surface's
edges that lie at its border. The posterior variance tells nothing beyond, since it does not know
how the object is shaped. Weights and the factor q were fitted on explorations of the train split,
see `vh_drake.experiments.stopping`. The explorer stops where the bound falls below what is wanted,
though never within the first round, and says so where that can't be had.

What no touch has come near and no part of the estimate leads to, such as the far end of a thin
tool, stays unknown to the bound.
"""

import dataclasses as dc
import math
from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.errors import BadInput
from vh_drake.exploration.coverage import Coverage
from vh_drake.exploration.explorer import ExplorerSettings, Known
from vh_drake.exploration.look_ahead import LookAhead
from vh_drake.exploration.loop import Body, begin, touches
from vh_drake.gpis.following import Sheet, follow_surface
from vh_drake.types import Array, Immutable

_BORDER = 0.005  # b_0
_LEAST_M = 2e-5  # added to s


@dc.dataclass(frozen=True)
class ErrorModel:
    """Weights w_0 to w_2, for lengths in mm, and the factor q."""

    weights: tuple[float, float, float] = (2.74, 1.04, 0.49)
    factor: float = 1.6


@dc.dataclass(frozen=True)
class StoppingSettings:
    """How it refines."""

    explorer: ExplorerSettings = dc.field(
        default_factory=lambda: ExplorerSettings(
            LookAhead(touches=2), 0.08, margin_m=0.03, clearance_m=0.001
        )
    )
    radii_m: tuple[float, ...] = (0.02, 0.014, 0.01, 0.007)  # of the rounds
    open_share: float = 0.03  # of the estimate that a round may leave
    most_touches: int = 200
    recent: int = 24  # touches whose surprise counts
    margin_m: float = 0.01  # of the estimate whose error is bounded
    model: ErrorModel = dc.field(default_factory=ErrorModel)


@dc.dataclass(frozen=True, eq=False)
class Refinement(Immutable):
    """What is known after a touch."""

    known: Known
    coverage: Coverage  # for a judge
    sheet: Sheet  # the estimate
    touches: int
    round: int  # 0 is the first
    features: Array  # (3,) 1, log s, log (b + b_0)
    bound_m: float  # of the error; inf within the first round


@dc.dataclass(frozen=True, eq=False)
class Stopped(Immutable):
    """How an exploration to an accuracy ended."""

    last: Refinement
    wanted_m: float
    met: bool  # as far as the explorer can tell
    reason: str  # in words


def explore_to(
    body: Body, wanted_m: float, settings: StoppingSettings | None = None, *, seed: int = 0
) -> Stopped:
    """Explore until the surface is believed to be as accurate as wanted.

    Args:
        body: the object.
        wanted_m: symmetric mean distance [m].
        settings: of rounds and touches.
        seed: of the first approach.

    Raises:
        BadInput: the accuracy is no positive number, or no straight way meets the object.
    """
    if not 0.0 < wanted_m < math.inf:
        raise BadInput(f"wanted_m={wanted_m:g}: choose a positive accuracy in metres")
    last: Refinement | None = None
    for last in refinements(body, settings, seed=seed):
        if last.bound_m <= wanted_m:
            return Stopped(last, wanted_m, True, "met")
    if last is None:
        raise BadInput("the estimate offers nothing to touch after the first contact")
    reason = (
        f"{1e3 * wanted_m:g} mm can't be met: after {last.touches} touches the error may be "
        f"{1e3 * last.bound_m:.1f} mm"
    )
    return Stopped(last, wanted_m, False, reason)


def refinements(
    body: Body, settings: StoppingSettings | None = None, *, seed: int = 0
) -> Iterator[Refinement]:
    """Touch after touch, round after round, until the last round or the touches end."""
    s = settings or StoppingSettings()
    known, coverage = begin(body, s.explorer, seed=seed)
    surprises: list[float] = []
    level = 0
    for count in range(1, s.most_touches + 1):
        step = next(touches(body, known, coverage, at_radius(s, level), seed=seed), None)
        if step is None:
            return
        surprises.append(abs(float(known.posterior.mean(step.touch.p_WC[None])[0])))
        known, coverage = step.known, step.coverage
        while level < len(s.radii_m) and is_explored(known, s, s.radii_m[level]):
            level += 1
        p = known.contacts.p_WC
        sheet = follow_surface(
            known.posterior, p, spacing_m=s.explorer.spacing_m, margin_m=s.margin_m
        )
        x = features(sheet, surprises[-s.recent :])
        bound = bound_m(x, s.model) if level > 0 else math.inf
        yield Refinement(known, coverage, sheet, count, level, x, bound)
        if level == len(s.radii_m):
            return


def at_radius(settings: StoppingSettings, level: int) -> ExplorerSettings:
    """The explorer's settings in a round: what is nearer than its radius counts as explored."""
    radius = settings.radii_m[level]
    return dc.replace(
        settings.explorer,
        fresh_m=radius,
        explored_radius_m=radius,
        barren_m=min(0.006, 0.5 * radius),
        set_aside_m=min(settings.explorer.set_aside_m, radius),
    )


def is_explored(known: Known, settings: StoppingSettings, radius_m: float) -> bool:
    """Whether hardly any of the estimate is farther than a radius from all contacts."""
    explorer, p = settings.explorer, known.contacts.p_WC
    sheet = follow_surface(
        known.posterior, p, spacing_m=explorer.spacing_m, margin_m=explorer.margin_m
    )
    if len(sheet.vertices) == 0:
        return False
    away = cKDTree(p).query(sheet.vertices)[0] > radius_m
    if len(known.set_aside):
        aside = cKDTree(known.set_aside).query(sheet.vertices)[0] < explorer.set_aside_m
        away &= ~aside
    return float(away.mean()) <= settings.open_share


def features(sheet: Sheet, surprises: list[float]) -> Array:
    """1, log s, log (b + b_0) (3,), s in mm; an empty estimate is all border.

    Args:
        sheet: the estimate.
        surprises: |potential| of the last contacts before they were known [m].
    """
    if len(sheet.faces) == 0:
        return np.array([1.0, math.log(1e3), math.log(1.0 + _BORDER)])
    surprise = 1e3 * (float(np.mean(surprises)) + _LEAST_M)
    return np.array([1.0, math.log(surprise), math.log(border_share(sheet) + _BORDER)])


def border_share(sheet: Sheet) -> float:
    """Share of the estimate's edges that belong to one triangle only."""
    f = sheet.faces
    edges = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    return float(np.mean(count == 1))


def bound_m(x: Array, model: ErrorModel) -> float:
    """The bound of the error [m] for features x (3,)."""
    return 1e-3 * model.factor * math.exp(float(x @ np.array(model.weights)))
