"""Compiled forward kinematics of a hand, one finger at a time.

Link 0 is the hand's base H; joint j moves link j + 1. Poses are rows of three by four: a
rotation and, in the last column, a position.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.geometry.compiling import bare_njit
from vh_drake.types import Array, IntArray


class HandArrays(NamedTuple):
    """A hand as arrays; n joints in chains, f fingers, m spheres sorted by link."""

    parent: IntArray  # (n,) link that carries joint j
    X_PL: Array  # (n, 3, 3, 4) link j + 1 in its parent: [j, 0] + s [j, 1] + c [j, 2], where s
    # and c are sine and cosine of a revolute joint's angle, or a slide's travel and 0
    prismatic: IntArray  # (n,) 1 where the joint slides
    first_joint: IntArray  # (f + 1,) finger i owns joints first_joint[i] to first_joint[i + 1]
    sphere_center: Array  # (m, 3) in the sphere's link [m]
    sphere_radius: Array  # (m,) [m]
    first_sphere: IntArray  # (n + 2,) link i owns spheres first_sphere[i] to [i + 1]
    sphere_lever: Array  # (m, n) largest distance of a sphere's centre from a joint's axis [m]


@bare_njit
def copy_pose(X: Array, result: Array) -> None:
    """Copy the first three rows of a pose."""
    for i in range(3):
        for j in range(4):
            result[i, j] = X[i, j]


@bare_njit
def place_joints(hand: HandArrays, angles: Array, first: int, last: int, X_WL: Array) -> None:
    """Poses of the links that joints first to last - 1 move, from their parents' poses.

    Angles are (n,) [rad or m]; X_WL (n + 1, 3, 4) is read and written.
    """
    X_PL = hand.X_PL
    for j in range(first, last):
        s, c = angles[j], 0.0
        if hand.prismatic[j] == 0:
            s, c = np.sin(angles[j]), np.cos(angles[j])
        parent = hand.parent[j]
        for i in range(4):
            x = X_PL[j, 0, 0, i] + s * X_PL[j, 1, 0, i] + c * X_PL[j, 2, 0, i]
            y = X_PL[j, 0, 1, i] + s * X_PL[j, 1, 1, i] + c * X_PL[j, 2, 1, i]
            z = X_PL[j, 0, 2, i] + s * X_PL[j, 1, 2, i] + c * X_PL[j, 2, 2, i]
            for k in range(3):
                X_WL[j + 1, k, i] = (
                    X_WL[parent, k, 0] * x + X_WL[parent, k, 1] * y + X_WL[parent, k, 2] * z
                )
        for k in range(3):
            X_WL[j + 1, k, 3] += X_WL[parent, k, 3]


@bare_njit
def sphere_at(centers: Array, s: int, X_WL: Array, link: int) -> tuple[float, float, float]:
    """Centre of sphere s, given in its link, where the link has pose X_WL[link]."""
    x, y, z = centers[s, 0], centers[s, 1], centers[s, 2]
    X = X_WL
    return (
        X[link, 0, 0] * x + X[link, 0, 1] * y + X[link, 0, 2] * z + X[link, 0, 3],
        X[link, 1, 0] * x + X[link, 1, 1] * y + X[link, 1, 2] * z + X[link, 1, 3],
        X[link, 2, 0] * x + X[link, 2, 1] * y + X[link, 2, 2] * z + X[link, 2, 3],
    )


@njit(cache=True)
def link_poses(hand: HandArrays, X_WH: Array, angles: Array) -> Array:
    """Poses (n + 1, 3, 4) of all links for a base pose (3, 4) and joint angles (n,)."""
    X_WL = np.empty((len(hand.parent) + 1, 3, 4))
    copy_pose(X_WH, X_WL[0])
    place_joints(hand, angles, 0, len(hand.parent), X_WL)
    return X_WL


@njit(cache=True)
def sphere_centers(hand: HandArrays, X_WL: Array) -> Array:
    """Centres (m, 3) of all spheres for link poses (n + 1, 3, 4)."""
    centers = np.empty((len(hand.sphere_radius), 3))
    for link in range(len(X_WL)):
        for s in range(hand.first_sphere[link], hand.first_sphere[link + 1]):
            centers[s, 0], centers[s, 1], centers[s, 2] = sphere_at(
                hand.sphere_center, s, X_WL, link
            )
    return centers
