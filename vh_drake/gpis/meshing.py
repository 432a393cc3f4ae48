"""Closed triangle meshes of a potential's zero set."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skimage.measure import marching_cubes

from vh_drake.types import Array, IntArray, ScalarGrid

_LEAST_VALUE = 1e-3  # of a step: nodes on the zero set itself would give triangles without area


def closed_mesh(potential: ScalarGrid, p_data: Array) -> tuple[Array, IntArray, Array]:
    """Vertices [m], faces and outward vertex normals of the parts that carry data.

    The zero set is closed at the border of the grid. Sheets and cavities that no datum lies next
    to are spurious (errata, "far from the data") and dropped.

    Args:
        potential: negative inside.
        p_data: (n, 3) observed points of the surface [m].
    """
    step = potential.spacing
    values = np.pad(potential.values, 1, constant_values=step)
    values[np.abs(values) < _LEAST_VALUE * step] = _LEAST_VALUE * step
    if not (values < 0).any():
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros((0, 3))
    vertices, faces, _, _ = marching_cubes(values, 0.0, gradient_direction="descent")
    vertices = vertices.astype(float) * step + potential.origin - step
    vertices, faces = parts_with_data(vertices, faces.astype(np.int64), p_data)
    return vertices, faces, vertex_normals(vertices, faces)


def parts_with_data(vertices: Array, faces: IntArray, p_data: Array) -> tuple[Array, IntArray]:
    """The connected parts of a mesh that are nearest to some datum and enclose a volume."""
    links = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(links)), links.T), shape=(len(vertices),) * 2)
    count, part = connected_components(graph, directed=False)
    volume = np.bincount(part[faces[:, 0]], _cone_volumes(vertices, faces), minlength=count)
    solid = np.flatnonzero(volume[part] > 0)
    _, nearest = cKDTree(vertices[solid]).query(p_data)
    kept = np.isin(part, part[solid][nearest])
    faces = faces[kept[faces[:, 0]]]
    return vertices[kept], (np.cumsum(kept) - 1)[faces]


def _cone_volumes(vertices: Array, faces: IntArray) -> Array:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volumes: Array = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    return volumes


def vertex_normals(vertices: Array, faces: IntArray) -> Array:
    """Outward unit normals (v, 3), the area-weighted mean over the faces at each vertex."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    face_normals = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for corner in range(3):
        for axis in range(3):
            normals[:, axis] += np.bincount(
                faces[:, corner], face_normals[:, axis], minlength=len(vertices)
            )
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit: Array = normals / np.maximum(length, 1e-300)
    return unit
