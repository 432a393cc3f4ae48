"""Moving the open hand to where it may start: off the object, above the table."""

import numpy as np
from numba import njit

from vh_drake.grasping.closing import above_table, advance, new_state, open_clearance
from vh_drake.grasping.field import FieldArrays, ObjectField
from vh_drake.grasping.motions import MotionArrays
from vh_drake.hand.kinematics import HandArrays, copy_pose
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
    lifts: Array = _free_lifts(hand.arrays, field.arrays, motion, poses, highest_m)
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
    ways: Array = _ways(
        hand.arrays, field.arrays, motion, poses, np.asarray(direction, np.float64), farthest_m
    )
    return ways


@njit(cache=True)
def _free_lifts(
    hand: HandArrays, field: FieldArrays, motion: MotionArrays, X_WH: Array, highest: float
) -> Array:
    state, pose = new_state(hand), np.empty((3, 4))
    result = np.full(len(X_WH), np.nan)
    for i in range(len(X_WH)):
        lift = 0.0
        while lift <= highest + 1e-9:
            copy_pose(X_WH[i], pose)
            for k in range(3):
                pose[k, 3] += lift * field.table[k]
            if open_clearance(hand, field, motion, pose, state) > 0:
                if above_table(hand, field, motion, pose, state):
                    result[i] = lift
                break
            lift += _STEP_M
    return result


@njit(cache=True)
def _ways(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    X_WH: Array,
    direction: Array,
    farthest: float,
) -> Array:
    state = new_state(hand)
    result = np.full(len(X_WH), np.nan)
    for i in range(len(X_WH)):
        if above_table(hand, field, motion, X_WH[i], state):
            way = advance(hand, field, motion, X_WH[i], direction, farthest, state)
            if 0 <= way < farthest:
                result[i] = way
    return result
