"""Compiled look-ups in an object's signed distance."""

import numpy as np

from vh_drake.geometry.compiling import bare_njit
from vh_drake.grasping.field import FieldArrays


@bare_njit
def signed_distance(field: FieldArrays, x: float, y: float, z: float) -> float:
    """Trilinear signed distance [m]; outside the grid a lower bound that continues it.

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
