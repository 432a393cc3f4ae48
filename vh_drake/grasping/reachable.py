"""Which of many grasps an arm can carry out."""

from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.control import kernels
from vh_drake.control.cartesian_position import GAIN_PER_S, MAX_ANGULAR_RAD_S, MAX_LINEAR_M_S
from vh_drake.control.cartesian_velocity import LIMIT_HORIZON_S, SINGULAR_THRESHOLD
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.null_space import GAIN
from vh_drake.geometry.meshes import Mask
from vh_drake.types import Array

_STEP_S = 0.12  # Of the controllers; with 0.02 s one way in fifty ends otherwise
_STEPS = 60  # from one pose to the next, at most
_TOLERANCES = (0.02, 0.002, 0.4)  # [rad], [m], patience without progress [s]
_METRES_A_RADIAN = 0.2  # A turn by one radian counts as much as this way
_ALIKE_M = 0.03  # Ways nearer than this to one that failed are not tried from home again ...
_ALIKE_SHARE = 0.33  # ... and not at all where that is so much nearer than any that did not fail


class _Controllers(NamedTuple):
    """What `kernels.roll_to_pose` wants."""

    limits: Array
    bounds: Array
    gains: Array
    tolerances: Array


def reachable(arm: ArmKinematics, X_WH: Array) -> Mask:
    """Which ways (n, k, 4, 4) of the hand the arm can go under its controllers, (n,).

    A way starts where the arm stands at the first pose of the most similar way that it could
    go, or else at home. Among ways that failed it is not tried again; a patient search might
    find a few more.
    """
    poses = np.ascontiguousarray(X_WH, np.float64)
    # Vectors (n, 12) whose distances tell how different first poses are [m].
    turns = _METRES_A_RADIAN / np.sqrt(2) * poses[:, 0, :3, :3].reshape(-1, 9)
    features = np.hstack([poses[:, 0, :3, 3], turns])
    gains = [GAIN_PER_S, SINGULAR_THRESHOLD, GAIN, LIMIT_HORIZON_S]
    controllers = _Controllers(
        arm.limits,
        np.array([MAX_ANGULAR_RAD_S, MAX_LINEAR_M_S]),
        np.array(gains),
        np.array(_TOLERANCES),
    )
    found: Mask = _reachable(arm.screws, poses, features, arm.home, controllers)
    return found


@njit(cache=True)
def _reachable(
    screws: tuple[Array, Array, Array],
    X_WH: Array,
    features: Array,
    home: Array,
    controllers: _Controllers,
) -> Mask:
    found = np.zeros(len(X_WH), np.bool_)
    first = np.empty((len(X_WH), len(home)))  # joint positions at the first poses
    path = np.empty((X_WH.shape[1] * _STEPS + 1, len(home)))
    for i in range(len(X_WH)):
        solved, solved_m = _nearest(features, i, found, True)
        _, failed_m = _nearest(features, i, found, False)
        if failed_m < min(_ALIKE_M, _ALIKE_SHARE * solved_m):
            continue
        if solved >= 0:
            path[0] = first[solved]
            found[i] = _goes(screws, X_WH[i], controllers, path, first[i])
        if not found[i] and failed_m >= min(_ALIKE_M, solved_m):
            path[0] = home
            found[i] = _goes(screws, X_WH[i], controllers, path, first[i])
    return found


@njit(cache=True)
def _goes(
    screws: tuple[Array, Array, Array],
    X_WH: Array,
    controllers: _Controllers,
    path: Array,
    first: Array,
) -> bool:
    """Whether the arm goes from path[0] through poses (k, 4, 4); notes where it is at the first."""
    row = 0
    for k in range(len(X_WH)):
        row, reached = kernels.roll_to_pose(
            screws[0],
            screws[1],
            screws[2],
            X_WH[k],
            controllers.limits,
            controllers.bounds,
            controllers.gains,
            controllers.tolerances,
            _STEP_S,
            path[: row + _STEPS],
            row,
        )
        if not reached:
            return False
        if k == 0:
            first[:] = path[row]
    return True


@njit(cache=True)
def _nearest(features: Array, i: int, found: Mask, wanted: bool) -> tuple[int, float]:
    """The nearest of the ways before i of one fate, and its distance; -1 where there is none."""
    nearest, least = -1, np.inf
    for j in range(i):
        if found[j] == wanted:
            square = 0.0
            for k in range(features.shape[1]):
                square += (features[i, k] - features[j, k]) ** 2
            if square < least:
                nearest, least = j, square
    return nearest, np.sqrt(least)
