"""Turned bodies and plain solids as exact watertight meshes."""

from itertools import pairwise

import numpy as np
import trimesh

from vh_drake.geometry.meshes import TriMesh, from_trimesh
from vh_drake.types import Array, IntArray

_SECTIONS = 48
_ROW_M = 0.008  # rows of triangles along the profile are at most so far apart
_AXIS_M = 1e-9  # radii below are on the axis


def lathe(profile: list[tuple[float, float]], *, flatten: float = 1.0) -> TriMesh:
    """Revolve a profile about z.

    Args:
        profile: (radius, z) [m] from the lowest point on the axis to the highest.
        flatten: Factor on y, below 1 for an oval section.
    """
    points = _subdivide(np.array(profile, dtype=np.float64))
    angles = np.arange(_SECTIONS) * 2 * np.pi / _SECTIONS
    circle = np.stack([np.cos(angles), flatten * np.sin(angles)], axis=1)
    vertices: list[Array] = []
    rings: list[IntArray] = []
    count = 0
    for radius, z in points:
        ring = radius * circle if radius > _AXIS_M else np.zeros((1, 2))
        vertices.append(np.column_stack([ring, np.full(len(ring), z)]))
        rings.append(np.resize(np.arange(count, count + len(ring)), _SECTIONS))
        count += len(ring)
    faces = np.vstack([_band(lower, upper) for lower, upper in pairwise(rings)])
    mesh = TriMesh(np.vstack(vertices), faces)
    proper = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return mesh.with_faces(proper)


def _subdivide(profile: Array) -> Array:
    """Insert points so that no step is longer than a row."""
    pieces = []
    for start, end in pairwise(profile):
        steps = max(1, int(np.ceil(np.linalg.norm(end - start) / _ROW_M)))
        pieces.append(start + np.arange(steps)[:, None] / steps * (end - start))
    return np.vstack([*pieces, profile[-1:]])


def _band(lower: IntArray, upper: IntArray) -> IntArray:
    """Triangles between two rings of vertex indices."""
    lower_next, upper_next = np.roll(lower, -1), np.roll(upper, -1)
    first = np.stack([lower, lower_next, upper_next], axis=1)
    second = np.stack([lower, upper_next, upper], axis=1)
    return np.vstack([first, second]).astype(np.int64)


def box(size: tuple[float, float, float]) -> TriMesh:
    """A box that stands on z = 0, sides along the axes [m]."""
    mesh = trimesh.creation.box(size)
    for _ in range(4):
        mesh = mesh.subdivide()
    return _raised(from_trimesh(mesh), size[2] / 2)


def cylinder(radius: float, length: float) -> TriMesh:
    """An upright cylinder that stands on z = 0 [m]."""
    return lathe([(0.0, 0.0), (radius, 0.0), (radius, length), (0.0, length)])


def sphere(radius: float, *, halvings: int = 4) -> TriMesh:
    """A sphere that rests on z = 0 [m].

    Args:
        radius: [m].
        halvings: of an icosahedron's edges; with 4 facets turn normals by 1.2 degrees (root mean
            square), with each more by half as much.
    """
    return _raised(from_trimesh(trimesh.creation.icosphere(halvings, radius)), radius)


def _raised(mesh: TriMesh, height: float) -> TriMesh:
    return TriMesh(mesh.vertices + np.array([0.0, 0.0, height]), mesh.faces)
