"""Points spread evenly over a surface."""

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.types import Array


def sample_surface(mesh: TriMesh, count: int, *, seed: int) -> tuple[Array, Array]:
    """Draw points uniformly by area.

    Args:
        mesh: Any mesh with some area.
        count: Number of points.
        seed: The same seed gives the same points.

    Returns:
        Points (count, 3) [m] and the outward unit normals of their faces (count, 3).

    Raises:
        BadInput: the count is negative, or the mesh has no area.
    """
    total = mesh.areas.sum()
    if count < 0 or not total > 0:
        raise BadInput(f"can't draw {count} points from a surface of {total:g} m²")
    rng = np.random.default_rng(seed)
    faces = rng.choice(len(mesh.faces), size=count, p=mesh.areas / total)
    u, v = rng.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = mesh.triangles[faces].swapaxes(0, 1)
    return a + u * (b - a) + v * (c - a), mesh.face_normals[faces]
