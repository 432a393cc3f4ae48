"""Moving the open hand to where it may start: off the object, above the table."""

import numpy as np
from numba import njit

from vh_drake.grasping.field import FieldArrays, ObjectField
from vh_drake.grasping.motions import MotionArrays
from vh_drake.grasping.open_hand import above_table, advance, is_free
from vh_drake.hand.kinematics import copy_pose
from vh_drake.hand.model import HandModel
from vh_drake.types import Array

_STEP_M = 0.005


def free_lift(
    hand: HandModel, field: ObjectField, motion: MotionArrays, X_WH: Array, *, highest_m: float
) -> Array:
    """How far (n,) each pose X_WH (n, 4, 4) must rise off the table until the open hand is free.

    In steps of 5 mm; NaN where `highest_m` is not enough [m].
    """
    poses = np.ascontiguousarray(X_WH[:, :3], np.float64)
    lifts: Array = _free_lifts(field.arrays, motion, poses, highest_m)
    return lifts


def way_to_contact(
    hand: HandModel,
    field: ObjectField,
    motion: MotionArrays,
    X_WH: Array,
    *,
    direction: Array,
    farthest_m: float,
) -> Array:
    """How far (n,) the open hand can move along a direction (3,) in H until it touches [m].

    NaN where the start is in collision with object or table, or nothing is met.
    """
    poses = np.ascontiguousarray(X_WH[:, :3], np.float64)
    toward = np.asarray(direction, np.float64)
    ways: Array = _ways(field.arrays, motion, poses, toward, farthest_m)
    return ways


@njit(cache=True)
def _free_lifts(field: FieldArrays, motion: MotionArrays, X_WH: Array, highest: float) -> Array:
    pose = np.empty((3, 4))
    result = np.full(len(X_WH), np.nan)
    for i in range(len(X_WH)):
        lift = 0.0
        while lift <= highest + 1e-9:
            copy_pose(X_WH[i], pose)
            for k in range(3):
                pose[k, 3] += lift * field.table[k]
            if is_free(field, motion, pose, 0.0):
                if above_table(field, motion, pose):
                    result[i] = lift
                break
            lift += _STEP_M
    return result


@njit(cache=True)
def _ways(
    field: FieldArrays,
    motion: MotionArrays,
    X_WH: Array,
    direction: Array,
    farthest: float,
) -> Array:
    result = np.full(len(X_WH), np.nan)
    for i in range(len(X_WH)):
        if above_table(field, motion, X_WH[i]):
            way = advance(field, motion, X_WH[i], direction, farthest)
            if 0 <= way < farthest:
                result[i] = way
    return result
