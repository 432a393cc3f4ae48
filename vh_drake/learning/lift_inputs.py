"""What the robot knows of a grasp that may tell whether the hand will lift the object by it.

Beside what the metric and the physical sense say, these are lengths of how the object lies in
the open hand, and where and at what slope the closed hand touches the estimate: a hand slips
off what it meets above its widest place.
"""

from collections.abc import Sequence

import numpy as np

from vh_drake.grasping.closing import Closure
from vh_drake.grasping.field import ObjectField
from vh_drake.grasping.in_hand import PlaceSettings, lie_in_hand, narrowest
from vh_drake.hand.model import HandModel
from vh_drake.learning.hints import hint_inputs
from vh_drake.learning.knowledge import Knowledge
from vh_drake.learning.metric import Prediction
from vh_drake.types import Array, Candidates, Surface

_LENGTH_M = 0.05  # one unit of lengths
_LOG_ODDS = 4.0
_SURE = 1e-4  # probabilities nearer to 0 or 1 are all alike
_CONTACTS = 8.0


def lift_inputs(known: Knowledge, hand: HandModel, told: Prediction) -> Array:
    """Numbers (n, INPUTS), all of one magnitude.

    Args:
        known: of n grasps.
        hand: that grasps.
        told: what the metric says of them.
    """
    candidates, estimate = known.candidates, known.estimate
    side = np.array([name == "side" for name in candidates.motion], float)
    inputs: Array = np.column_stack(
        [
            _odds(told.success),
            _odds(told.rate),
            side,
            hint_inputs(known.hints, len(candidates))[:, 1:],
            _lie(candidates, known.surface, estimate, hand),
            _touched(known.hints.closures, candidates, estimate),
        ]
    )
    return inputs


def with_success(inputs: Array, success: Array) -> Array:
    """Inputs (n, INPUTS) where the metric's word is another (n,)."""
    return np.column_stack([_odds(success), inputs[:, 1:]])


def _odds(probability: Array) -> Array:
    sure = np.clip(probability, _SURE, 1 - _SURE)
    odds: Array = np.log(sure / (1 - sure)) / _LOG_ODDS
    return odds


def _lie(candidates: Candidates, surface: Surface, estimate: ObjectField, hand: HandModel) -> Array:
    """How the object lies in the open hand, and its size (n, 9)."""
    names, up = np.array(candidates.motion), np.asarray(estimate.table.normal, dtype=float)
    lie = np.zeros((len(candidates), 5))
    for motion in np.unique(names):
        own = names == motion
        found = lie_in_hand(
            candidates.X_WH[own], str(motion), surface.vertices, estimate, hand, PlaceSettings()
        )
        lie[own] = np.column_stack(
            [
                found.met * _LENGTH_M,
                found.middle,
                found.excess,
                found.beside,
                estimate.table.height(candidates.X_WH[own, :3, 3]),
            ]
        )
    heights = estimate.table.height(surface.vertices)
    center = estimate.table.height(estimate.center)
    size = [narrowest(surface.vertices, up), heights.max(), center, _edge(estimate)]
    return np.column_stack([lie, np.tile(size, (len(lie), 1))]) / _LENGTH_M


def _edge(estimate: ObjectField) -> float:
    """Of a cube of the object's volume [m]."""
    inside = np.clip(0.5 - estimate.distance.values / estimate.distance.spacing, 0.0, 1.0)
    return float(np.cbrt(inside.sum()) * estimate.distance.spacing)


def _touched(closures: Sequence[Closure], candidates: Candidates, estimate: ObjectField) -> Array:
    """Where and at what slope the undisturbed hand touches (n, 8)."""
    rows = [
        _touch(closure, X_WH, estimate)
        for closure, X_WH in zip(closures, candidates.X_WH, strict=True)
    ]
    return np.array(rows).reshape(-1, 8)


def _touch(closure: Closure, X_WH: Array, estimate: ObjectField) -> list[float]:
    if len(closure.p_WC) == 0:
        return [0.0] * 8
    up = np.asarray(estimate.table.normal, dtype=float)
    slope, height = closure.n_WC @ up, estimate.table.height(closure.p_WC)
    middle = closure.p_WC.mean(axis=0)
    aside = middle - estimate.center
    aside = aside - (aside @ up) * up
    lengths = [
        height.mean(),
        height.min(),
        np.linalg.norm(closure.p_WC - middle, axis=1).max(),
        np.linalg.norm(aside),
        np.linalg.norm(closure.X_WH[:3, 3] - X_WH[:3, 3]),
    ]
    return [slope.mean(), slope.min(), slope.max(), *(float(x) / _LENGTH_M for x in lengths)]


INPUTS = 3 + 10 + 9 + 8
