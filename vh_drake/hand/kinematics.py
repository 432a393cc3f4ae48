"""Compiled forward kinematics of a hand, one finger at a time.

Link 0 is the hand's base H; joint j moves link j + 1. Poses are rows of three by four: a
rotation and, in the last column, a position.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.types import Array, IntArray


class HandArrays(NamedTuple):
    """A hand as arrays; n joints in chains, f fingers, m spheres sorted by link."""

    parent: IntArray  # (n,) link that carries joint j
    X_PF: Array  # (n, 3, 4) joint frame at angle 0, in the parent link
    X_ML: Array  # (n, 3, 4) link in the moved joint frame
    axis: Array  # (n, 3) in the joint frame
    prismatic: IntArray  # (n,) 1 where the joint slides
    first_joint: IntArray  # (f + 1,) finger i owns joints first_joint[i] to first_joint[i + 1]
    sphere_center: Array  # (m, 3) in the sphere's link [m]
    sphere_radius: Array  # (m,) [m]
    first_sphere: IntArray  # (n + 2,) link i owns spheres first_sphere[i] to [i + 1]
    sphere_lever: Array  # (m, n) largest distance of a sphere's centre from a joint's axis [m]


@njit(cache=True)
def compose(a: Array, b: Array, result: Array) -> None:
    """result = a b for poses of three by four."""
    for i in range(3):
        for j in range(4):
            value = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
            result[i, j] = value + (a[i, 3] if j == 3 else 0.0)


@njit(cache=True)
def copy_pose(X: Array, result: Array) -> None:
    """Copy the first three rows of a pose."""
    for i in range(3):
        for j in range(4):
            result[i, j] = X[i, j]


@njit(cache=True)
def axis_angle(axis: Array, angle: float, result: Array) -> None:
    """Rotation about a unit axis (Rodrigues), position 0."""
    s, c = np.sin(angle), np.cos(angle)
    x, y, z = axis[0], axis[1], axis[2]
    v = 1.0 - c
    result[0, 0], result[0, 1], result[0, 2] = c + x * x * v, x * y * v - z * s, x * z * v + y * s
    result[1, 0], result[1, 1], result[1, 2] = y * x * v + z * s, c + y * y * v, y * z * v - x * s
    result[2, 0], result[2, 1], result[2, 2] = z * x * v - y * s, z * y * v + x * s, c + z * z * v
    for i in range(3):
        result[i, 3] = 0.0


@njit(cache=True)
def place_joints(
    hand: HandArrays, angles: Array, first: int, last: int, X_WL: Array, work: Array
) -> None:
    """Poses of the links that joints first to last - 1 move, from their parents' poses.

    Args:
        angles: (n,) [rad or m].
        X_WL: (n + 1, 3, 4) link poses, read and written.
        work: (3, 3, 4) scratch.
    """
    for j in range(first, last):
        compose(X_WL[hand.parent[j]], hand.X_PF[j], work[0])
        if hand.prismatic[j]:
            axis_angle(hand.axis[j], 0.0, work[1])
            for i in range(3):
                work[1, i, 3] = angles[j] * hand.axis[j, i]
        else:
            axis_angle(hand.axis[j], angles[j], work[1])
        compose(work[0], work[1], work[2])
        compose(work[2], hand.X_ML[j], X_WL[j + 1])


@njit(cache=True)
def sphere_at(hand: HandArrays, s: int, X: Array) -> tuple[float, float, float]:
    """Centre of sphere s where its link has pose X."""
    x, y, z = hand.sphere_center[s, 0], hand.sphere_center[s, 1], hand.sphere_center[s, 2]
    return (
        X[0, 0] * x + X[0, 1] * y + X[0, 2] * z + X[0, 3],
        X[1, 0] * x + X[1, 1] * y + X[1, 2] * z + X[1, 3],
        X[2, 0] * x + X[2, 1] * y + X[2, 2] * z + X[2, 3],
    )


@njit(cache=True)
def link_poses(hand: HandArrays, X_WH: Array, angles: Array) -> Array:
    """Poses (n + 1, 3, 4) of all links for a base pose (3, 4) and joint angles (n,)."""
    X_WL = np.empty((len(hand.parent) + 1, 3, 4))
    copy_pose(X_WH, X_WL[0])
    place_joints(hand, angles, 0, len(hand.parent), X_WL, np.empty((3, 3, 4)))
    return X_WL


@njit(cache=True)
def sphere_centers(hand: HandArrays, X_WL: Array) -> Array:
    """Centres (m, 3) of all spheres for link poses (n + 1, 3, 4)."""
    centers = np.empty((len(hand.sphere_radius), 3))
    for link in range(len(X_WL)):
        for s in range(hand.first_sphere[link], hand.first_sphere[link + 1]):
            centers[s, 0], centers[s, 1], centers[s, 2] = sphere_at(hand, s, X_WL[link])
    return centers
