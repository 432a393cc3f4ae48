"""Coloured triangles for pictures: arrows, balls, cones, tubes; many in one mesh.

WebGL draws lines one pixel wide, whatever is asked; so pictures are made of triangles.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vh_drake.types import Array, IntArray

_SIDES = 10


class ColorMesh(NamedTuple):
    """Triangles with a colour at each vertex."""

    vertices: Array  # (v, 3) [m]
    faces: IntArray  # (f, 3), counter-clockwise seen from outside
    colors: Array  # (v, 3) red, green, blue in 0..1


def joined(parts: Sequence[ColorMesh]) -> ColorMesh:
    """All parts in one mesh; no parts give an empty one."""
    if not parts:
        return ColorMesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros((0, 3)))
    first = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    return ColorMesh(
        np.vstack([part.vertices for part in parts]),
        np.vstack([part.faces + start for part, start in zip(parts, first, strict=True)]),
        np.vstack([part.colors for part in parts]),
    )


def arrows(p: Array, direction: Array, colors: Array, *, length: float, radius: float) -> ColorMesh:
    """Arrows whose tips are at p + length * direction.

    Args:
        p: (n, 3) where they start [m].
        direction: (n, 3) unit vectors.
        colors: (n, 3) of each.
        length: from end to end [m].
        radius: of the shaft [m].
    """
    neck = length - min(4.0 * radius, 0.5 * length)
    profile = np.array(
        [[0.0, 0.0], [radius, 0.0], [radius, neck], [2.2 * radius, neck], [0.0, length]]
    )
    return _copies(profile, p, direction, colors)


def balls(p: Array, colors: Array, *, radius: float) -> ColorMesh:
    """Balls around p (n, 3) [m] in colours (n, 3)."""
    angle = np.linspace(0.0, np.pi, 7)
    profile = radius * np.column_stack([np.sin(angle), -np.cos(angle)])
    return _copies(profile, p, np.tile([0.0, 0.0, 1.0], (len(p), 1)), colors)


def cones(p: Array, axis: Array, colors: Array, *, length: float, slope: float) -> ColorMesh:
    """Cones that stand on their points.

    Args:
        p: (n, 3) the points [m].
        axis: (n, 3) unit vectors from there along the cones.
        colors: (n, 3) of each.
        length: along the axis [m].
        slope: tangent of the half angle; of a friction cone the coefficient of friction.
    """
    profile = length * np.array([[0.0, 0.0], [slope, 1.0], [0.0, 1.0]])
    return _copies(profile, p, axis, colors)


def tube(p: Array, color: Array, *, radius: float) -> ColorMesh:
    """A round tube along a polyline p (n, 3) [m]; pieces without length are left out."""
    steps = np.diff(p, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    pieces = [
        _copies(
            np.array([[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]]),
            start[None],
            step[None] / length,
            color[None],
        )
        for start, step, length in zip(p[:-1], steps, lengths, strict=True)
        if length > 1e-9
    ]
    joints = p[1:-1]
    return joined([*pieces, balls(joints, np.tile(color, (len(joints), 1)), radius=radius)])


def _copies(profile: Array, p: Array, axis: Array, colors: Array) -> ColorMesh:
    """A solid of revolution, placed at each p (n, 3) with its axis along `axis` (n, 3)."""
    vertices, faces = _revolved(profile)
    x = _perpendicular(axis)
    frames = np.stack([x, np.cross(axis, x), axis], axis=-1)  # (n, 3, 3)
    placed = np.einsum("nij,vj->nvi", frames, vertices) + p[:, None]
    shifts = len(vertices) * np.arange(len(p))
    return ColorMesh(
        placed.reshape(-1, 3),
        (faces[None] + shifts[:, None, None]).reshape(-1, 3),
        np.repeat(colors, len(vertices), axis=0),
    )


def _revolved(profile: Array) -> tuple[Array, IntArray]:
    """Turn a profile (k, 2) of radius and height, from the bottom up, about z."""
    angle = 2 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices = np.vstack(
        [np.column_stack([r * ring, np.full(_SIDES, height)]) for r, height in profile]
    )
    faces = []
    after = np.roll(np.arange(_SIDES), -1)
    for low in range(len(profile) - 1):
        a, b = low * _SIDES + np.arange(_SIDES), low * _SIDES + after
        faces += [np.column_stack([a, b, b + _SIDES]), np.column_stack([a, b + _SIDES, a + _SIDES])]
    return vertices, np.vstack(faces)


def _perpendicular(axis: Array) -> Array:
    """(n, 3) unit vectors across unit vectors (n, 3)."""
    helper = np.where(np.abs(axis[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    across = np.cross(axis, helper)
    unit: Array = across / np.linalg.norm(across, axis=1, keepdims=True)
    return unit
