"""A way around an object: out of its surroundings, along a sphere, and straight in again."""

import numpy as np

from vh_drake.types import Array

_MOST_ARC = np.pi / 4  # of one cubic curve; the deviation from a circle is below 1e-5 of its radius


def way_around(
    p_from: Array, departure_W: Array, p_to: Array, n_to: Array, *, center: Array, radius_m: float
) -> Array:
    """Control points (k, 4, 3) of curves from one place to another around a sphere.

    Args:
        p_from: (3,) start inside the sphere [m].
        departure_W: (3,) unit direction in which to leave it.
        p_to: (3,) end inside the sphere [m].
        n_to: (3,) unit direction from which to come to the end.
        center: (3,) of the sphere [m].
        radius_m: of the sphere.
    """
    start = _exit(p_from - center, departure_W, radius_m)
    end = _exit(p_to - center, n_to, radius_m)
    arcs = _arcs(start, end) + center
    return np.concatenate(
        [_line(p_from, center + start)[None], arcs, _line(center + end, p_to)[None]]
    )


def _exit(p: Array, direction: Array, radius: float) -> Array:
    """Where a ray from inside leaves a sphere about the origin."""
    along = float(p @ direction)
    way = -along + np.sqrt(max(along**2 + radius**2 - float(p @ p), 0.0))
    left: Array = p + way * direction
    return left


def _line(a: Array, b: Array) -> Array:
    line: Array = a + np.linspace(0.0, 1.0, 4)[:, None] * (b - a)
    return line


def _arcs(a: Array, b: Array) -> Array:
    """Control points (k, 4, 3) of the shorter arc about the origin from a to b."""
    radius = float(np.linalg.norm(a))
    x = a / radius
    side = b - (b @ x) * x
    if np.linalg.norm(side) < 1e-9 * radius:  # Half a turn has no preferred plane.
        side = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
    y = side / np.linalg.norm(side)
    angle = float(np.arctan2(b @ y, b @ x))
    count = max(int(np.ceil(angle / _MOST_ARC)), 1)
    handle = 4.0 / 3.0 * np.tan(angle / count / 4.0)
    turns = np.linspace(0.0, angle, count + 1)
    p = radius * (np.outer(np.cos(turns), x) + np.outer(np.sin(turns), y))
    tangent = radius * (np.outer(np.cos(turns), y) - np.outer(np.sin(turns), x))
    return np.stack(
        [p[:-1], p[:-1] + handle * tangent[:-1], p[1:] - handle * tangent[1:], p[1:]], axis=1
    )
