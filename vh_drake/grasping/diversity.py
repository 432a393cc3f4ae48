"""Keeping candidates that differ."""

import numpy as np

from vh_drake.hand.model import HandModel
from vh_drake.types import Array, IntArray

_METRES_A_RADIAN = 0.06  # A turn by one radian counts as much as this way of the power TCP


def pose_features(X_WH: Array, hand: HandModel) -> Array:
    """Vectors (n, 9) [m] whose distances tell how different poses (n, 4, 4) are."""
    tcp = X_WH[:, :3, :3] @ np.asarray(hand.description.tcps["power"]) + X_WH[:, :3, 3]
    axes = X_WH[:, :3, [0, 2]].reshape(len(X_WH), 6)
    return np.hstack([tcp, _METRES_A_RADIAN / np.sqrt(2) * axes])


def spread(X_WH: Array, group: Array, hand: HandModel, count: int) -> IntArray:
    """Indices of at most `count` poses (n, 4, 4), far from each other, the farthest first.

    Greedy: the next pose is the one farthest from all before it. `group` (n,) keeps kinds of
    grasps apart: two of different kinds are never close.
    """
    if len(X_WH) == 0:
        return np.zeros(0, np.int64)
    features = np.column_stack([pose_features(X_WH, hand), np.asarray(group, np.float64)])
    chosen = np.zeros(min(count, len(X_WH)), np.int64)
    distance = np.full(len(X_WH), np.inf)
    for i in range(1, len(chosen)):
        last = features[chosen[i - 1]]
        distance = np.minimum(distance, ((features - last) ** 2).sum(axis=1))
        chosen[i] = np.argmax(distance)
    return chosen
