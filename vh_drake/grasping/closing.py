"""Closing an underactuated hand around a signed distance field, without dynamics.

Fingers follow their free-space motion. A link that touches locks its joint and those before
it; the rest of the finger goes on. A hand that moves meanwhile stops at the first contact.
What touches first, and when, follows from the paths of the hand's spheres.
"""

import dataclasses as dc
from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.geometry.compiling import bare_njit
from vh_drake.grasping.field import FieldArrays, ObjectField
from vh_drake.grasping.first_touch import Queue, first_touch
from vh_drake.grasping.lookup import outward_normal, signed_distance
from vh_drake.grasping.motions import MotionArrays
from vh_drake.grasping.open_hand import (
    CONTACT_M,
    above_table,
    advance,
    is_free,
    moved,
    turned,
)
from vh_drake.hand.kinematics import HandArrays, copy_pose, place_joints
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, IntArray

_PALM_CONTACT_M = 0.001


@dc.dataclass(frozen=True, eq=False)
class Closure:
    """Where the hand touches once closed."""

    started_free: bool  # False: the open hand was in collision, and nothing else is known
    p_WC: Array  # (c, 3) contact positions on the object's surface [m]
    n_WC: Array  # (c, 3) outward normals of the object there
    links: IntArray  # (c,) which link of the hand touches; 0 is the base
    angles: Array  # (n,) final joint angles [rad or m]
    X_WH: Array  # (4, 4) final hand pose


class ClosingState(NamedTuple):
    """Buffers of one closing with n joints."""

    angles: Array  # (n,)
    X_WL: Array  # (n + 1, 3, 4)
    touched: IntArray  # (n + 1,) 1 where the link touches
    p: Array  # (n + 1, 3) its contact
    n: Array  # (n + 1, 3) outward normal there
    queue: Queue


def close_hand(
    hand: HandModel,
    field: ObjectField,
    motion: MotionArrays,
    X_WH: Array,
    *,
    palm_advance_m: float = 0.0,
) -> Closure:
    """Close a hand from one pose.

    Args:
        hand: With n joints.
        field: Object and table; the table is an obstacle for the open hand alone.
        motion: Free-space motion of hand and fingers.
        X_WH: (4, 4) start pose.
        palm_advance_m: First move the open hand out of its palm until it touches, at most
            this far.
    """
    state = new_state(hand.arrays)
    start = np.ascontiguousarray(X_WH[:3], np.float64)
    palm = np.asarray(hand.description.palm) / np.linalg.norm(hand.description.palm)
    arrays = field.arrays
    free = above_table(arrays, motion, start) and close_fingers(
        hand.arrays, arrays, motion, start, palm, palm_advance_m, state
    )
    links = np.flatnonzero(state.touched) if free else np.zeros(0, np.int64)
    pose = np.vstack([state.X_WL[0], [0, 0, 0, 1]])
    return Closure(free, state.p[links], state.n[links], links, state.angles.copy(), pose)


@njit(cache=True)
def new_state(hand: HandArrays) -> ClosingState:
    """Buffers for a hand."""
    n, m = len(hand.parent), len(hand.sphere_radius)
    integers = np.zeros((3, m), np.int64)
    queue = Queue(integers[0], integers[1], integers[2], np.zeros(m), np.zeros((3, 4)))
    return ClosingState(
        np.zeros(n),
        np.zeros((n + 1, 3, 4)),
        np.zeros(n + 1, np.int64),
        np.zeros((n + 1, 3)),
        np.zeros((n + 1, 3)),
        queue,
    )


@bare_njit
def close_fingers(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    X_WH: Array,
    palm: Array,
    palm_advance: float,
    state: ClosingState,
) -> bool:
    """Close the hand from X_WH (3, 4), whatever the table; False where it starts in collision.

    The state holds the contacts, the final angles and the final link poses.
    """
    for link in range(len(state.touched)):
        state.touched[link] = 0
    way = 0.0
    if palm_advance > 0:
        way = advance(field, motion, X_WH, palm, palm_advance)
        if way < 0:
            return False
    elif not is_free(field, motion, X_WH, -CONTACT_M):
        return False
    base = state.X_WL[0]
    copy_pose(X_WH, base)
    a, b, c = turned(X_WH, palm)
    base[0, 3] += way * a
    base[1, 3] += way * b
    base[2, 3] += way * c
    start, end = 0.0, len(motion.angles) - 1.0
    if motion.moving:
        links = (0, len(state.touched))
        start = first_touch(field, motion, base, 0, links, (start, end), state.queue)[2]
        _move_hand(motion, start, base)
    _touch_palm(field, motion, state)
    for finger in range(len(hand.first_joint) - 1):
        _close_finger(hand, field, motion, finger, start, state)
    return True


@bare_njit
def _close_finger(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    finger: int,
    start: float,
    state: ClosingState,
) -> None:
    """Close one finger of a hand that stands still; a link is as many as are locked."""
    locked, last = hand.first_joint[finger], hand.first_joint[finger + 1]
    time, end = start, len(motion.angles) - 1.0
    while locked < last:
        frame = hand.parent[locked]
        depth = 1 + motion.paths.depth[frame]
        bunch, sphere, time = first_touch(
            field,
            motion,
            state.X_WL[frame],
            depth,
            (locked + 1, last + 1),
            (time, end),
            state.queue,
        )
        if bunch < 0:
            _move_joints(hand, motion, end, locked, last, state)
            return
        touching = motion.bunches.link[bunch]
        _move_joints(hand, motion, time, locked, touching, state)
        for link in range(locked + 1, touching):
            _touch_link(field, motion, link, CONTACT_M, state)
        _record(field, motion, touching, sphere, state)
        locked = touching


@bare_njit
def _move_hand(motion: MotionArrays, time: float, X: Array) -> None:
    """Move the hand from its start pose X (3, 4) to where it is at a time."""
    knot = min(int(time), len(motion.X_H0H) - 2)
    part, path = time - knot, motion.X_H0H
    for i in range(3):
        row = (X[i, 0], X[i, 1], X[i, 2])
        for j in range(4):
            total = X[i, 3] if j == 3 else 0.0
            for k in range(3):
                x = path[knot, k, j]
                total += row[k] * (x + part * (path[knot + 1, k, j] - x))
            X[i, j] = total


@bare_njit
def _move_joints(
    hand: HandArrays, motion: MotionArrays, time: float, first: int, last: int, state: ClosingState
) -> None:
    """Place joints first to last - 1 and their links as they are at a time in free space."""
    knot = min(int(time), len(motion.angles) - 2)
    part = time - knot
    for j in range(first, last):
        a, b = motion.angles[knot, j], motion.angles[knot + 1, j]
        state.angles[j] = a + part * (b - a)
    place_joints(hand, state.angles, first, last, state.X_WL)


@bare_njit
def _touch_palm(field: FieldArrays, motion: MotionArrays, state: ClosingState) -> None:
    _touch_link(field, motion, 0, _PALM_CONTACT_M, state)


@bare_njit
def _touch_link(
    field: FieldArrays, motion: MotionArrays, link: int, gap: float, state: ClosingState
) -> None:
    """Note the contact of a link's nearest sphere, if it is nearer than a gap [m]."""
    bunches, nearest = motion.bunches, -1
    for bunch in range(bunches.first_bunch[link], bunches.first_bunch[link + 1]):
        x, y, z = moved(state.X_WL[link], bunches.ball_center, bunch)
        if signed_distance(field, x, y, z) - bunches.ball_radius[bunch] > gap:
            continue
        for s in range(bunches.first_sphere[bunch], bunches.first_sphere[bunch + 1]):
            x, y, z = moved(state.X_WL[link], bunches.sphere_center, s)
            distance = signed_distance(field, x, y, z) - bunches.sphere_radius[s]
            if distance <= gap:
                nearest, gap = s, distance
    if nearest >= 0:
        _record(field, motion, link, nearest, state)


@bare_njit
def _record(
    field: FieldArrays, motion: MotionArrays, link: int, sphere: int, state: ClosingState
) -> None:
    """Note a link's contact, unless it lies at or below the table's top."""
    x, y, z = moved(state.X_WL[link], motion.bunches.sphere_center, sphere)
    nx, ny, nz = outward_normal(field, x, y, z)
    away = signed_distance(field, x, y, z)
    px, py, pz = x - away * nx, y - away * ny, z - away * nz
    table = field.table
    if table[0] * px + table[1] * py + table[2] * pz - table[3] < CONTACT_M:
        return
    state.touched[link] = 1
    state.p[link, 0], state.p[link, 1], state.p[link, 2] = px, py, pz
    state.n[link, 0], state.n[link, 1], state.n[link, 2] = nx, ny, nz
