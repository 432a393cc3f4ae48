"""Where the links of a hand go in free space, and how far their spheres go with them.

As long as nothing blocks a finger, each of its links follows a path that depends on the time
alone, seen from the frame that carries the finger; once a link is blocked, the links beyond it
do so seen from that link. The paths are tabulated together with the way that spheres go, so
that a sphere at a distance d from the object is free until it has gone another d (sphere
tracing, Hart 1996).
"""

from typing import NamedTuple

import numpy as np

from vh_drake.grasping.bunches import Bunches
from vh_drake.hand.kinematics import HandArrays, link_poses
from vh_drake.types import Array, IntArray

POSE = 12  # Values of a pose's first three rows


class BunchPaths(NamedTuple):
    """Paths of the links of b bunches at k evenly spaced times; between them straight.

    Each bunch has a row for every frame from which it can be seen to move: where the hand
    starts, the hand's base, and then outwards up to the link that carries the bunch's own.
    """

    table: Array  # (p, k, 13) pose of the bunch's link, and the way of its fastest part [m]
    slowness: Array  # (p, s + 1) the fastest part's way over that of the ball and each sphere
    first_row: IntArray  # (b,)
    depth: IntArray  # (n + 1,) number of joints between the base and a link


def bunch_paths(hand: HandArrays, bunches: Bunches, X_H0H: Array, angles: Array) -> BunchPaths:
    """Tabulate the paths for poses X_H0H (k, 3, 4) and joint angles (k, n)."""
    X_HL = np.array([link_poses(hand, np.eye(4), q) for q in angles])  # (k, n + 1, 3, 4)
    inwards = [_inwards(hand, link) for link in range(len(hand.parent) + 1)]
    rows: list[Array] = []
    slow: list[Array] = []
    first: list[int] = []
    for bunch, link in enumerate(bunches.link):
        first.append(len(rows))
        own = slice(bunches.first_sphere[bunch], bunches.first_sphere[bunch + 1])
        centers = np.vstack([bunches.ball_center[bunch], bunches.sphere_center[own]])
        seen = [_times(X_H0H, X_HL[:, link])]
        seen += [_times(_inverse(X_HL[:, frame]), X_HL[:, link]) for frame in inwards[link]]
        for X in seen:
            row, slowness = _row(X, centers)
            rows.append(row)
            slow.append(slowness)
    most = max(map(len, slow))
    padded = np.array([np.pad(s, (0, most - len(s))) for s in slow])
    return BunchPaths(
        np.array(rows), padded, np.array(first), np.array([len(path) for path in inwards])
    )


def _row(X: Array, centers: Array) -> tuple[Array, Array]:
    """One row of the table, and of the slowness, for poses (k, 3, 4) and points (s + 1, 3)."""
    p = np.einsum("kij,sj->ski", X[..., :3], centers) + X[..., 3]
    steps = np.linalg.norm(np.diff(p, axis=1), axis=2)  # (s + 1, k - 1)
    fastest = steps.max(axis=0)
    share = np.divide(steps, fastest, out=np.zeros_like(steps), where=fastest > 0).max(axis=1)
    way = np.concatenate([[0.0], np.cumsum(fastest)])
    with np.errstate(divide="ignore"):
        return np.column_stack([X.reshape(len(X), POSE), way]), 1 / share


def _inwards(hand: HandArrays, link: int) -> list[int]:
    """The links that carry a link, from the base outwards."""
    path: list[int] = []
    while link > 0:
        link = int(hand.parent[link - 1])
        path.insert(0, link)
    return path


def _inverse(X: Array) -> Array:
    """Inverses of poses (k, 3, 4)."""
    R = X[..., :3].swapaxes(1, 2)
    return np.concatenate([R, -R @ X[..., 3:]], axis=2)


def _times(X_AB: Array, X_BC: Array) -> Array:
    """Products of poses (k, 3, 4)."""
    turned: Array = X_AB[..., :3] @ X_BC
    turned[..., 3] += X_AB[..., 3]
    return turned
