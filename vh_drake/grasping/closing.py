"""Closing an underactuated hand around a signed distance field, without dynamics.

Fingers follow their free-space motion. A link that touches locks its joint and those before
it; the rest of the finger goes on. A hand that moves meanwhile stops at the first contact.
Time advances by conservative steps, in which no sphere can move farther than its distance to
the object, but by no less than a fixed one; a contact passed by such a least step is bisected.
"""

import dataclasses as dc
from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.grasping.field import FieldArrays, ObjectField
from vh_drake.grasping.motions import MotionArrays
from vh_drake.hand.kinematics import HandArrays, bare_njit, copy_pose, place_joints, sphere_at
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, IntArray

CONTACT_M = 0.0005  # A sphere this near touches
_PALM_CONTACT_M = 0.001
_EARLY = 0.01  # Spheres due within this time are looked up along with the others
_LEAST_STEP = 1 / 40  # of time; a finger moves by no more than 8 mm meanwhile
_LEAST_PALM_STEP = 1 / 16  # a moving palm by no more than 5 mm
_BISECTIONS = 5  # bring the time of a contact down to 0.2 mm


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
    """Buffers of one closing; n joints, m spheres."""

    angles: Array  # (n,)
    X_WL: Array  # (n + 1, 3, 4)
    X_WH0: Array  # (3, 4) start pose of the hand, after the palm's advance
    due: Array  # (m,) time before which a sphere can't touch
    touched: IntArray  # (n + 1,) 1 where the link touches
    p: Array  # (n + 1, 3) its contact
    n: Array  # (n + 1, 3) outward normal there
    gap: Array  # (m,) distance of a sphere when it was last looked at


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
    free = above_table(hand.arrays, arrays, motion, start, state) and close_fingers(
        hand.arrays, arrays, motion, start, palm, palm_advance_m, state
    )
    links = np.flatnonzero(state.touched) if free else np.zeros(0, np.int64)
    pose = np.vstack([state.X_WL[0], [0, 0, 0, 1]])
    return Closure(free, state.p[links], state.n[links], links, state.angles.copy(), pose)


@njit(cache=True)
def new_state(hand: HandArrays) -> ClosingState:
    """Buffers for a hand."""
    n, m = len(hand.parent), len(hand.sphere_radius)
    return ClosingState(
        np.zeros(n),
        np.zeros((n + 1, 3, 4)),
        np.zeros((3, 4)),
        np.zeros(m),
        np.zeros(n + 1, np.int64),
        np.zeros((n + 1, 3)),
        np.zeros((n + 1, 3)),
        np.zeros(m),
    )


@bare_njit
def above_table(
    hand: HandArrays, field: FieldArrays, motion: MotionArrays, X_WH: Array, state: ClosingState
) -> bool:
    """Whether the open hand is clear of the table; leaves the open link poses in the state."""
    _open(hand, motion, X_WH, state)
    table = field.table
    for link in range(len(state.X_WL)):
        for s in range(hand.first_sphere[link], hand.first_sphere[link + 1]):
            x, y, z = sphere_at(hand.sphere_center, s, state.X_WL, link)
            height = table[0] * x + table[1] * y + table[2] * z - table[3]
            if height < hand.sphere_radius[s] - CONTACT_M:
                return False
    return True


@bare_njit
def open_clearance(
    hand: HandArrays, field: FieldArrays, motion: MotionArrays, X_WH: Array, state: ClosingState
) -> float:
    """Least distance of the open hand from the object [m]; stops looking in collision."""
    _open(hand, motion, X_WH, state)
    least: float = np.inf
    for link in range(len(state.X_WL)):
        for s in range(hand.first_sphere[link], hand.first_sphere[link + 1]):
            x, y, z = sphere_at(hand.sphere_center, s, state.X_WL, link)
            distance = signed_distance(field, x, y, z) - hand.sphere_radius[s]
            state.due[s] = distance
            least = min(least, distance)
            if least < -CONTACT_M:
                return least
    return least


@bare_njit
def advance(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    X_WH: Array,
    direction: Array,
    farthest: float,
    state: ClosingState,
) -> float:
    """How far the open hand can move along a direction in H before it touches [m].

    The result is at most `farthest`, and -1 where the start is in collision.
    """
    if open_clearance(hand, field, motion, X_WH, state) < -CONTACT_M:
        return -1.0
    a, b, c = turned(X_WH, direction)
    moved = 0.0
    while moved < farthest:
        upcoming = np.inf
        for link in range(len(state.X_WL)):
            for s in range(hand.first_sphere[link], hand.first_sphere[link + 1]):
                if state.due[s] <= moved + CONTACT_M:
                    x, y, z = sphere_at(hand.sphere_center, s, state.X_WL, link)
                    distance = signed_distance(field, x + moved * a, y + moved * b, z + moved * c)
                    distance -= hand.sphere_radius[s]
                    if distance <= CONTACT_M:
                        return moved
                    state.due[s] = moved + distance
                upcoming = min(upcoming, state.due[s])
        moved = upcoming
    return farthest


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
    copy_pose(X_WH, state.X_WH0)
    if palm_advance > 0:
        way = advance(hand, field, motion, X_WH, palm, palm_advance, state)
        if way < 0:
            return False
        a, b, c = turned(X_WH, palm)
        state.X_WH0[0, 3] += way * a
        state.X_WH0[1, 3] += way * b
        state.X_WH0[2, 3] += way * c
    if open_clearance(hand, field, motion, state.X_WH0, state) < -CONTACT_M:
        return False
    start = 0.0
    if motion.moving:
        start = 1.0
        for finger in range(-1, len(hand.first_joint) - 1):
            _set_due(hand, motion, finger, state)
            start = _run(hand, field, motion, finger, 0.0, start, True, state)
        _place_hand(motion, start, state)
    _touch_palm(hand, field, state)
    for finger in range(len(hand.first_joint) - 1):
        if motion.moving:
            first, last = _finger_spheres(hand, finger)
            for s in range(first, last):
                state.due[s] = start
        else:
            _set_due(hand, motion, finger, state)
        _run(hand, field, motion, finger, start, 1.0, False, state)
    return True


@bare_njit
def turned(X: Array, v: Array) -> tuple[float, float, float]:
    """A vector v (3,) turned by a pose's rotation."""
    return (
        X[0, 0] * v[0] + X[0, 1] * v[1] + X[0, 2] * v[2],
        X[1, 0] * v[0] + X[1, 1] * v[1] + X[1, 2] * v[2],
        X[2, 0] * v[0] + X[2, 1] * v[1] + X[2, 2] * v[2],
    )


@bare_njit
def _open(hand: HandArrays, motion: MotionArrays, X_WH: Array, state: ClosingState) -> None:
    for j in range(len(state.angles)):
        state.angles[j] = motion.angles[0, j]
    copy_pose(X_WH, state.X_WL[0])
    place_joints(hand, state.angles, 0, len(state.angles), state.X_WL)


@bare_njit
def _finger_spheres(hand: HandArrays, finger: int) -> tuple[int, int]:
    """First and one past the last sphere of a finger's links; of the base for -1."""
    if finger < 0:
        return hand.first_sphere[0], hand.first_sphere[1]
    first = hand.first_sphere[hand.first_joint[finger] + 1]
    return first, hand.first_sphere[hand.first_joint[finger + 1] + 1]


@bare_njit
def _set_due(hand: HandArrays, motion: MotionArrays, finger: int, state: ClosingState) -> None:
    """Turn the open hand's distances into times before which no sphere can touch."""
    first, last = _finger_spheres(hand, finger)
    first_joint = hand.first_joint[finger] if finger >= 0 else 0
    last_joint = hand.first_joint[finger + 1] if finger >= 0 else 0
    for s in range(first, last):
        speed = motion.hand_speed[s]
        for j in range(first_joint, last_joint):
            speed += hand.sphere_lever[s, j] * motion.joint_rate[j]
        state.due[s] = state.due[s] / max(speed, 1e-9)


@bare_njit
def _place_hand(motion: MotionArrays, time: float, state: ClosingState) -> None:
    knot = min(int(time * (len(motion.angles) - 1)), len(motion.angles) - 2)
    part = time * (len(motion.angles) - 1) - knot
    path, start, X_WL = motion.X_H0H, state.X_WH0, state.X_WL
    for j in range(4):
        x = path[knot, 0, j] + part * (path[knot + 1, 0, j] - path[knot, 0, j])
        y = path[knot, 1, j] + part * (path[knot + 1, 1, j] - path[knot, 1, j])
        z = path[knot, 2, j] + part * (path[knot + 1, 2, j] - path[knot, 2, j])
        for i in range(3):
            X_WL[0, i, j] = start[i, 0] * x + start[i, 1] * y + start[i, 2] * z
    for i in range(3):
        X_WL[0, i, 3] += start[i, 3]


@bare_njit
def _move_joints(
    hand: HandArrays, motion: MotionArrays, time: float, first: int, last: int, state: ClosingState
) -> None:
    knot = min(int(time * (len(motion.angles) - 1)), len(motion.angles) - 2)
    part = time * (len(motion.angles) - 1) - knot
    for j in range(first, last):
        a, b = motion.angles[knot, j], motion.angles[knot + 1, j]
        state.angles[j] = a + part * (b - a)
    place_joints(hand, state.angles, first, last, state.X_WL)


@bare_njit
def _run(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    finger: int,
    start: float,
    end: float,
    with_hand: bool,
    state: ClosingState,
) -> float:
    """Close one finger (-1: move the base alone) and return the time at which it stopped.

    With the hand moving, the first contact ends the run and is not recorded.
    """
    last = hand.first_joint[finger + 1] if finger >= 0 else 0
    locked = hand.first_joint[finger] if finger >= 0 else 0
    step = _LEAST_STEP if finger >= 0 else _LEAST_PALM_STEP
    before, time = start, start
    while True:
        _move(hand, motion, finger, locked, time, with_hand, state)
        touching, least, due = _look(hand, field, motion, finger, locked, time, with_hand, state)
        if touching >= 0 and least < -CONTACT_M and time > before:
            time, touching = _step_back(
                hand, field, motion, finger, locked, before, time, with_hand, state
            )
        if touching >= 0:
            if with_hand:
                return time
            _record_touching(hand, field, locked, touching, state)
            locked = touching
            before = time
        if time >= end or (finger >= 0 and locked == last):
            return time
        if touching < 0:
            before, time = time, min(max(due, time + step), end)


@bare_njit
def _step_back(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    finger: int,
    locked: int,
    free: float,
    deep: float,
    with_hand: bool,
    state: ClosingState,
) -> tuple[float, int]:
    """Time of the contact between a time without one and one inside, and the link there.

    The finger, and the hand if it moves, stand at that time afterwards.
    """
    touching, least, time = -1, 0.0, deep
    for _ in range(_BISECTIONS):
        time = 0.5 * (free + deep)
        _move(hand, motion, finger, locked, time, with_hand, state)
        touching, least, _ = _look(hand, field, motion, finger, locked, time, with_hand, state)
        if touching < 0:
            free = time
        elif least >= -CONTACT_M:
            return time, touching
        else:
            deep = time
    if touching < 0:
        time = deep
        _move(hand, motion, finger, locked, time, with_hand, state)
        touching, least, _ = _look(hand, field, motion, finger, locked, time, with_hand, state)
    return time, touching


@bare_njit
def _move(
    hand: HandArrays,
    motion: MotionArrays,
    finger: int,
    locked: int,
    time: float,
    with_hand: bool,
    state: ClosingState,
) -> None:
    """Place the hand, where it moves, and the joints of a finger that are not locked."""
    if with_hand:
        _place_hand(motion, time, state)
    if finger >= 0:
        _move_joints(hand, motion, time, locked, hand.first_joint[finger + 1], state)


@bare_njit
def _look(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    finger: int,
    locked: int,
    time: float,
    with_hand: bool,
    state: ClosingState,
) -> tuple[int, float, float]:
    """The outermost link that touches (else -1), how near it is, and when to look again.

    `state.due` stays at or before `time` for spheres that touch.
    """
    first = locked + 1 if finger >= 0 else 0
    last = hand.first_joint[finger + 1] + 1 if finger >= 0 else 1
    touching, least, upcoming = -1, np.inf, np.inf
    for link in range(first, last):
        for s in range(hand.first_sphere[link], hand.first_sphere[link + 1]):
            if state.due[s] <= time + _EARLY:
                x, y, z = sphere_at(hand.sphere_center, s, state.X_WL, link)
                distance = signed_distance(field, x, y, z) - hand.sphere_radius[s]
                state.gap[s] = distance
                if distance <= CONTACT_M:
                    touching, least = link, min(least, distance)
                    state.due[s] = 0.0
                    continue
                speed = motion.hand_speed[s] if with_hand else 0.0
                for j in range(locked, last - 1):
                    speed += hand.sphere_lever[s, j] * motion.joint_rate[j]
                state.due[s] = time + distance / max(speed, 1e-9)
            upcoming = min(upcoming, state.due[s])
    return touching, least, upcoming


@bare_njit
def _record_touching(
    hand: HandArrays, field: FieldArrays, locked: int, touching: int, state: ClosingState
) -> None:
    """Note the deepest contact of each link up to the outermost that touches."""
    for link in range(locked + 1, touching + 1):
        deepest, gap = -1, CONTACT_M
        for s in range(hand.first_sphere[link], hand.first_sphere[link + 1]):
            if state.due[s] <= 0 and state.gap[s] <= gap:
                deepest, gap = s, state.gap[s]
        if deepest >= 0:
            _record(hand, field, link, deepest, state)


@bare_njit
def _record(hand: HandArrays, field: FieldArrays, link: int, s: int, state: ClosingState) -> None:
    """Note a link's contact, unless it lies at or below the table's top."""
    x, y, z = sphere_at(hand.sphere_center, s, state.X_WL, link)
    nx, ny, nz = outward_normal(field, x, y, z)
    away = signed_distance(field, x, y, z)
    px, py, pz = x - away * nx, y - away * ny, z - away * nz
    table = field.table
    if table[0] * px + table[1] * py + table[2] * pz - table[3] < CONTACT_M:
        return
    state.touched[link] = 1
    state.p[link, 0], state.p[link, 1], state.p[link, 2] = px, py, pz
    state.n[link, 0], state.n[link, 1], state.n[link, 2] = nx, ny, nz


@bare_njit
def _touch_palm(hand: HandArrays, field: FieldArrays, state: ClosingState) -> None:
    nearest, gap = -1, _PALM_CONTACT_M
    for s in range(hand.first_sphere[0], hand.first_sphere[1]):
        x, y, z = sphere_at(hand.sphere_center, s, state.X_WL, 0)
        distance = signed_distance(field, x, y, z) - hand.sphere_radius[s]
        if distance < gap:
            nearest, gap = s, distance
    if nearest >= 0:
        _record(hand, field, 0, nearest, state)


@bare_njit
def signed_distance(field: FieldArrays, x: float, y: float, z: float) -> float:
    """Trilinear signed distance; outside the grid a lower bound that continues it.

    For a point p outside a box that holds the object and its nearest point q in the box,
    every point o of the object satisfies |p - o|² ≥ |p - q|² + |q - o|².
    """
    values = field.values
    scale = 1.0 / field.spacing
    u = (x - field.origin[0]) * scale
    v = (y - field.origin[1]) * scale
    w = (z - field.origin[2]) * scale
    cu = min(max(u, 0.0), values.shape[0] - 1.0)
    cv = min(max(v, 0.0), values.shape[1] - 1.0)
    cw = min(max(w, 0.0), values.shape[2] - 1.0)
    i0, j0 = min(int(cu), values.shape[0] - 2), min(int(cv), values.shape[1] - 2)
    k0 = min(int(cw), values.shape[2] - 2)
    a, b, c = cu - i0, cv - j0, cw - k0
    # Unsigned indices save the test for negative ones.
    i, j, k = np.uintp(i0), np.uintp(j0), np.uintp(k0)
    i1, j1, k1 = np.uintp(i0 + 1), np.uintp(j0 + 1), np.uintp(k0 + 1)
    low = (1 - b) * ((1 - c) * values[i, j, k] + c * values[i, j, k1]) + b * (
        (1 - c) * values[i, j1, k] + c * values[i, j1, k1]
    )
    high = (1 - b) * ((1 - c) * values[i1, j, k] + c * values[i1, j, k1]) + b * (
        (1 - c) * values[i1, j1, k] + c * values[i1, j1, k1]
    )
    inside: float = (1 - a) * low + a * high
    beyond = ((u - cu) ** 2 + (v - cv) ** 2 + (w - cw) ** 2) * field.spacing**2
    if beyond > 0:
        inside = np.sqrt(inside * inside + beyond)
    return inside


@bare_njit
def outward_normal(field: FieldArrays, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Unit gradient of the signed distance by central differences."""
    h = 0.5 * field.spacing
    gx = signed_distance(field, x + h, y, z) - signed_distance(field, x - h, y, z)
    gy = signed_distance(field, x, y + h, z) - signed_distance(field, x, y - h, z)
    gz = signed_distance(field, x, y, z + h) - signed_distance(field, x, y, z - h)
    length = max(np.sqrt(gx * gx + gy * gy + gz * gz), 1e-12)
    return gx / length, gy / length, gz / length
