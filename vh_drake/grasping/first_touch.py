"""When and where a hand that moves in free space first touches an object."""

from typing import NamedTuple

import numpy as np

from vh_drake.geometry.compiling import bare_njit
from vh_drake.grasping.bunch_paths import POSE, BunchPaths
from vh_drake.grasping.field import FieldArrays
from vh_drake.grasping.lookup import signed_distance
from vh_drake.grasping.motions import MotionArrays
from vh_drake.grasping.open_hand import CONTACT_M, NEAR_M
from vh_drake.types import Array, IntArray


class Queue(NamedTuple):
    """What is still to be looked at, in no order; buffers for b bunches."""

    bunch: IntArray  # (b,)
    row: IntArray  # (b,) of its path
    near: IntArray  # (b,) 1 where its ball has come near
    when: Array  # (b,) the time before which nothing of it touches
    X_WL: Array  # (3, 4) pose of the link that is looked at


@bare_njit
def first_touch(
    field: FieldArrays,
    motion: MotionArrays,
    X_WF: Array,
    frame: int,
    links: tuple[int, int],
    times: tuple[float, float],
    queue: Queue,
) -> tuple[int, int, float]:
    """Which bunch and sphere of links first to last - 1 touch first (else -1, -1), and when.

    Looks at what may touch soonest, and then again once that has gone as far as it was away.

    Args:
        field: the object.
        motion: of the hand.
        X_WF: (3, 4) the frame from which the paths are seen.
        frame: its place among the rows of a bunch.
        links: first, and one past the last.
        times: at which to begin and to end.
        queue: buffers.
    """
    bunches, paths = motion.bunches, motion.paths
    count, end = 0, times[1]
    for bunch in range(bunches.first_bunch[links[0]], bunches.first_bunch[links[1]]):
        queue.bunch[count], queue.row[count] = bunch, paths.first_row[bunch] + frame
        queue.near[count], queue.when[count] = 0, times[0]
        count += 1
    while count > 0:
        place = 0
        for other in range(1, count):
            if queue.when[other] < queue.when[place]:
                place = other
        bunch, row, time = queue.bunch[place], queue.row[place], queue.when[place]
        _place_link(paths, row, time, X_WF, queue.X_WL)
        step = 0.0
        if queue.near[place] == 0:
            step = _ball_step(field, motion, bunch, row, queue.X_WL)
            queue.near[place] = step <= 0.0
        if queue.near[place]:
            touching, step = _sphere_step(field, motion, bunch, row, queue.X_WL)
            if touching >= 0:
                return bunch, touching, time
        later = _after(paths, row, time, step)
        if later < end or (queue.near[place] and time < end):
            queue.when[place] = min(later, end)
        else:
            count -= 1
            queue.bunch[place], queue.row[place] = queue.bunch[count], queue.row[count]
            queue.near[place], queue.when[place] = queue.near[count], queue.when[count]
    return -1, -1, end


@bare_njit
def _ball_step(field: FieldArrays, motion: MotionArrays, bunch: int, row: int, X: Array) -> float:
    """The way of the bunch's fastest part in which its ball stays free; 0 where it is near."""
    x, y, z = _moved(X, motion.bunches.ball_center, bunch)
    gap = signed_distance(field, x, y, z) - motion.bunches.ball_radius[bunch]
    return gap * motion.paths.slowness[row, 0] if gap > NEAR_M else 0.0


@bare_njit
def _sphere_step(
    field: FieldArrays, motion: MotionArrays, bunch: int, row: int, X: Array
) -> tuple[int, float]:
    """The deepest sphere in contact (else -1), and the way until one may be."""
    bunches = motion.bunches
    touching, deepest, step = -1, CONTACT_M, np.inf
    first = bunches.first_sphere[bunch]
    for s in range(first, bunches.first_sphere[bunch + 1]):
        x, y, z = _moved(X, bunches.sphere_center, s)
        gap = signed_distance(field, x, y, z) - bunches.sphere_radius[s]
        if gap <= deepest:
            touching, deepest = s, gap
        step = min(step, max(gap, NEAR_M) * motion.paths.slowness[row, 1 + s - first])
    return touching, step


@bare_njit
def _moved(X: Array, points: Array, i: int) -> tuple[float, float, float]:
    x, y, z = points[i, 0], points[i, 1], points[i, 2]
    return (
        X[0, 0] * x + X[0, 1] * y + X[0, 2] * z + X[0, 3],
        X[1, 0] * x + X[1, 1] * y + X[1, 2] * z + X[1, 3],
        X[2, 0] * x + X[2, 1] * y + X[2, 2] * z + X[2, 3],
    )


@bare_njit
def _place_link(paths: BunchPaths, row: int, time: float, X_WF: Array, X_WL: Array) -> None:
    """Write a link's pose (3, 4) at a time."""
    knot = min(int(time), paths.table.shape[1] - 2)
    part, table = time - knot, paths.table
    for j in range(4):
        x = table[row, knot, j] + part * (table[row, knot + 1, j] - table[row, knot, j])
        y = table[row, knot, 4 + j] + part * (table[row, knot + 1, 4 + j] - table[row, knot, 4 + j])
        z = table[row, knot, 8 + j] + part * (table[row, knot + 1, 8 + j] - table[row, knot, 8 + j])
        for i in range(3):
            X_WL[i, j] = X_WF[i, 0] * x + X_WF[i, 1] * y + X_WF[i, 2] * z
    for i in range(3):
        X_WL[i, 3] += X_WF[i, 3]


@bare_njit
def _after(paths: BunchPaths, row: int, time: float, step: float) -> float:
    """When the fastest part has gone a step further; infinite where it never does."""
    table, last = paths.table, paths.table.shape[1] - 2
    knot = min(int(time), last)
    start = table[row, knot, POSE]
    end = table[row, knot + 1, POSE]
    way = start + (time - knot) * (end - start) + step
    while end < way:
        knot += 1
        if knot > last:
            return np.inf
        start, end = end, table[row, knot + 1, POSE]
    later: float = knot + (way - start) / (end - start)
    return later
