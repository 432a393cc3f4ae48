"""Compiled arithmetic of rotations."""

import numpy as np
from numba import njit

from vh_drake.types import Array


@njit(cache=True)
def axis_rotation(axis: Array, angle: float) -> Array:
    """Rodrigues' formula for a unit axis (3,)."""
    x, y, z = axis
    s, c = np.sin(angle), np.cos(angle)
    d = 1.0 - c
    return np.array(
        [
            [c + x * x * d, x * y * d - z * s, x * z * d + y * s],
            [y * x * d + z * s, c + y * y * d, y * z * d - x * s],
            [z * x * d - y * s, z * y * d + x * s, c + z * z * d],
        ]
    )


@njit(cache=True)
def rotation_vector(R: Array) -> Array:
    """Axis times angle in 0..pi, by way of the quaternion (Shepperd 1978)."""
    diagonal = np.array([R[0, 0], R[1, 1], R[2, 2], R[0, 0] + R[1, 1] + R[2, 2]])
    i = int(np.argmax(diagonal))
    quaternion = np.empty(4)  # x y z w, up to scale
    if i == 3:
        quaternion[0] = R[2, 1] - R[1, 2]
        quaternion[1] = R[0, 2] - R[2, 0]
        quaternion[2] = R[1, 0] - R[0, 1]
        quaternion[3] = 1.0 + diagonal[3]
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        quaternion[i] = 1.0 + 2.0 * R[i, i] - diagonal[3]
        quaternion[j] = R[j, i] + R[i, j]
        quaternion[k] = R[k, i] + R[i, k]
        quaternion[3] = R[k, j] - R[j, k]
    if quaternion[3] < 0.0:
        quaternion = -quaternion
    sine = np.sqrt(np.sum(quaternion[:3] ** 2))
    if sine < 1e-15:
        return np.zeros(3)
    vector: Array = quaternion[:3] * (2.0 * np.arctan2(sine, quaternion[3]) / sine)
    return vector


@njit(cache=True)
def between(X_WA: Array, X_WB: Array, share: float) -> Array:
    """Pose (4, 4) at a share of the way: straight in position, evenly about one axis."""
    R_AB = np.ascontiguousarray(X_WA[:3, :3].T) @ np.ascontiguousarray(X_WB[:3, :3])
    turn = rotation_vector(R_AB)
    angle = np.sqrt(np.sum(turn * turn))
    X = X_WA.copy()
    if angle > 0.0:
        part = axis_rotation(turn / angle, share * angle)
        X[:3, :3] = np.ascontiguousarray(X_WA[:3, :3]) @ part
    X[:3, 3] += share * (X_WB[:3, 3] - X_WA[:3, 3])
    return X
