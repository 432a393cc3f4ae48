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
from vh_drake.grasping.motions import hand_axes
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
    """Numbers (n, LIFT_NUMBERS), all of one magnitude.

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
            _touched(known.hints.closures, candidates, known.surface, estimate, hand),
        ]
    )
    return inputs


def with_success(inputs: Array, success: Array) -> Array:
    """Inputs (n, LIFT_NUMBERS) where the metric's word is another (n,)."""
    return np.column_stack([_odds(success), inputs[:, 1:]])


def _odds(probability: Array) -> Array:
    sure = np.clip(probability, _SURE, 1 - _SURE)
    odds: Array = np.log(sure / (1 - sure)) / _LOG_ODDS
    return odds


def _lie(candidates: Candidates, surface: Surface, estimate: ObjectField, hand: HandModel) -> Array:
    """How the object lies in the open hand, and its size (n, 12)."""
    names, up = np.array(candidates.motion), np.asarray(estimate.table.normal, dtype=float)
    fingers, palm = (candidates.X_WH[:, :3, :3] @ axis for axis in hand_axes(hand))
    lie = np.zeros((len(candidates), 7))
    for motion in np.unique(names):
        own = names == motion
        found = lie_in_hand(
            candidates.X_WH[own], str(motion), surface.vertices, estimate, hand, PlaceSettings()
        )
        lie[own, :4] = np.column_stack(
            [found.met * _LENGTH_M, found.middle, found.excess, found.beside]
        )
    tcp = candidates.X_WH[:, :3, :3] @ np.asarray(hand.description.tcps["power"])
    to_center = estimate.center - tcp - candidates.X_WH[:, :3, 3]
    lie[:, 4] = estimate.table.height(candidates.X_WH[:, :3, 3])
    lie[:, 5] = (to_center * np.cross(fingers, palm)).sum(axis=1)
    lie[:, 6] = _LENGTH_M * (fingers @ up)
    heights = estimate.table.height(surface.vertices)
    center = estimate.table.height(estimate.center)
    size = [
        narrowest(surface.vertices, up),
        heights.max(),
        center,
        _edge(estimate),
        _longest(surface.vertices),
    ]
    return np.column_stack([lie, np.tile(size, (len(lie), 1))]) / _LENGTH_M


def _edge(estimate: ObjectField) -> float:
    """Of a cube of the object's volume [m]."""
    inside = np.clip(0.5 - estimate.distance.values / estimate.distance.spacing, 0.0, 1.0)
    return float(np.cbrt(inside.sum()) * estimate.distance.spacing)


def _longest(vertices: Array) -> float:
    """Length along the principal axis of points (v, 3) [m]."""
    centered = vertices - vertices.mean(axis=0)
    axis = np.linalg.eigh(centered.T @ centered)[1][:, -1]
    return float(np.ptp(centered @ axis))


def _touched(
    closures: Sequence[Closure],
    candidates: Candidates,
    surface: Surface,
    estimate: ObjectField,
    hand: HandModel,
) -> Array:
    """Where and at what slope the undisturbed hand touches (n, 10)."""
    top = float(estimate.table.height(surface.vertices).max())
    rows = [
        _touch(closure, X_WH, top, estimate, hand)
        for closure, X_WH in zip(closures, candidates.X_WH, strict=True)
    ]
    return np.array(rows).reshape(-1, 10)


def _touch(
    closure: Closure, X_WH: Array, top: float, estimate: ObjectField, hand: HandModel
) -> list[float]:
    if len(closure.p_WC) == 0:
        return [0.0] * 10
    up = np.asarray(estimate.table.normal, dtype=float)
    slope, height = closure.n_WC @ up, estimate.table.height(closure.p_WC)
    middle = closure.p_WC.mean(axis=0)
    aside = middle - estimate.center
    aside = aside - (aside @ up) * up
    lengths = [
        height.mean(),
        height.min(),
        top - height.mean(),
        np.linalg.norm(closure.p_WC - middle, axis=1).max(),
        np.linalg.norm(aside),
        np.linalg.norm(closure.X_WH[:3, 3] - X_WH[:3, 3]),
    ]
    own = [float(x) / _LENGTH_M for x in lengths]
    return [slope.mean(), slope.min(), slope.max(), _facing(closure, hand), *own]


def _facing(closure: Closure, hand: HandModel) -> float:
    """Cosine between the mean normals at the thumb and elsewhere; -1 where they face each other.

    It is 1 where one of them touches nothing.
    """
    thumb = hand.thumb_links[closure.links]
    if thumb.all() or not thumb.any():
        return 1.0
    return float(closure.n_WC[thumb].mean(axis=0) @ closure.n_WC[~thumb].mean(axis=0))


LIFT_NUMBERS = 3 + 10 + 12 + 10
