"""The open hand beside an object and over a table, before anything closes."""

import numpy as np

from vh_drake.geometry.compiling import bare_njit
from vh_drake.grasping.field import FieldArrays
from vh_drake.grasping.lookup import signed_distance
from vh_drake.grasping.motions import MotionArrays
from vh_drake.types import Array

CONTACT_M = 0.0005  # A sphere this near touches
NEAR_M = 2 * CONTACT_M  # The least step; it ends no deeper than a contact may be


@bare_njit
def above_table(field: FieldArrays, motion: MotionArrays, X_WH: Array) -> bool:
    """Whether the open hand in pose X_WH (3, 4) is clear of the table."""
    bunches, table = motion.bunches, field.table
    for bunch in range(len(bunches.link)):
        x, y, z = moved(X_WH, motion.open_ball, bunch)
        height = table[0] * x + table[1] * y + table[2] * z - table[3]
        if height >= bunches.ball_radius[bunch] - CONTACT_M:
            continue
        for s in range(bunches.first_sphere[bunch], bunches.first_sphere[bunch + 1]):
            x, y, z = moved(X_WH, motion.open_sphere, s)
            height = table[0] * x + table[1] * y + table[2] * z - table[3]
            if height < bunches.sphere_radius[s] - CONTACT_M:
                return False
    return True


@bare_njit
def is_free(field: FieldArrays, motion: MotionArrays, X_WH: Array, least: float) -> bool:
    """Whether the open hand in pose X_WH (3, 4) is at least so far from the object [m]."""
    bunches = motion.bunches
    for bunch in range(len(bunches.link)):
        x, y, z = moved(X_WH, motion.open_ball, bunch)
        if signed_distance(field, x, y, z) - bunches.ball_radius[bunch] >= least:
            continue
        for s in range(bunches.first_sphere[bunch], bunches.first_sphere[bunch + 1]):
            x, y, z = moved(X_WH, motion.open_sphere, s)
            if signed_distance(field, x, y, z) - bunches.sphere_radius[s] < least:
                return False
    return True


@bare_njit
def advance(
    field: FieldArrays, motion: MotionArrays, X_WH: Array, direction: Array, farthest: float
) -> float:
    """How far the open hand can move along a direction in H before it touches [m].

    The result is at most `farthest`, and -1 where the start is in collision.
    """
    if not is_free(field, motion, X_WH, -CONTACT_M):
        return -1.0
    a, b, c = turned(X_WH, direction)
    bunches, way = motion.bunches, farthest
    for bunch in range(len(bunches.link)):
        x, y, z = moved(X_WH, motion.open_ball, bunch)
        gone, gap = 0.0, np.inf
        while gone < way:
            gap = signed_distance(field, x + gone * a, y + gone * b, z + gone * c)
            gap -= bunches.ball_radius[bunch]
            if gap <= NEAR_M:
                break
            gone += gap
        while gone < way:
            gap = np.inf
            for s in range(bunches.first_sphere[bunch], bunches.first_sphere[bunch + 1]):
                x, y, z = moved(X_WH, motion.open_sphere, s)
                distance = signed_distance(field, x + gone * a, y + gone * b, z + gone * c)
                gap = min(gap, distance - bunches.sphere_radius[s])
            if gap <= CONTACT_M:
                way = gone
            gone += max(gap, NEAR_M)
    return way


@bare_njit
def moved(X: Array, points: Array, i: int) -> tuple[float, float, float]:
    """The i-th of points (n, 3) in the frame that a pose (3, 4) is expressed in."""
    x, y, z = points[i, 0], points[i, 1], points[i, 2]
    return (
        X[0, 0] * x + X[0, 1] * y + X[0, 2] * z + X[0, 3],
        X[1, 0] * x + X[1, 1] * y + X[1, 2] * z + X[1, 3],
        X[2, 0] * x + X[2, 1] * y + X[2, 2] * z + X[2, 3],
    )


@bare_njit
def turned(X: Array, v: Array) -> tuple[float, float, float]:
    """A vector v (3,) turned by a pose's rotation."""
    return (
        X[0, 0] * v[0] + X[0, 1] * v[1] + X[0, 2] * v[2],
        X[1, 0] * v[0] + X[1, 1] * v[1] + X[1, 2] * v[2],
        X[2, 0] * v[0] + X[2, 1] * v[1] + X[2, 2] * v[2],
    )
