"""Keeping candidates that differ, and telling how much they do."""

import dataclasses as dc

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.hand.model import HandModel
from vh_drake.types import Array, IntArray

_METRES_A_RADIAN = 0.06  # A turn by one radian counts as much as this way of the power TCP
_APART_M = 0.02  # Poses farther apart than this are clearly different grasps


@dc.dataclass(frozen=True)
class Diversity:
    """How much the poses of candidates differ, by the distances of `pose_features`."""

    nearest_m: float  # median distance of a pose to its nearest neighbour
    spread_m: float  # root mean square distance from their mean
    distinct: int  # poses of which each is at least 2 cm from the others


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


def diversity(X_WH: Array, hand: HandModel) -> Diversity:
    """How much poses (n, 4, 4) differ; all 0 for fewer than two, but for one distinct pose."""
    features = pose_features(X_WH, hand)
    if len(features) < 2:
        return Diversity(0.0, 0.0, len(features))
    nearest = cKDTree(features).query(features, k=2)[0][:, 1]
    offset = features - features.mean(axis=0)
    distance, distinct = np.full(len(features), np.inf), 0
    while distance.max() >= _APART_M:
        chosen = features[np.argmax(distance)]
        distance = np.minimum(distance, np.linalg.norm(features - chosen, axis=1))
        distinct += 1
    spread_m = float(np.sqrt((offset**2).sum(axis=1).mean()))
    return Diversity(float(np.median(nearest)), spread_m, distinct)
