"""Signed distance to a mesh, on a grid and between its nodes; negative inside."""

import numpy as np
from numba import njit
from scipy.ndimage import distance_transform_edt

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.triangle_kernels import (
    crossings_along_z,
    distances_by_sweeping,
    point_distances,
    splat_distances,
)
from vh_drake.types import Array, IntArray, ScalarGrid

MAX_NODES = 20_000_000
_BAND_CELLS = 2


def signed_distance_grid(mesh: TriMesh, *, spacing: float, padding: float) -> ScalarGrid:
    """Signed distance [m] at grid nodes around a watertight mesh.

    Exact within two cells of the surface. Farther out each node takes a triangle that is
    nearest to a node beside it: never too small, and too large by less than two cells.

    Args:
        mesh: Watertight; of an open mesh the sign follows `winding_grid`.
        spacing: Between nodes [m].
        padding: Free space around the mesh [m].

    Raises:
        BadInput: spacing or padding unusable, or more than MAX_NODES nodes.
    """
    origin, shape = grid_around(mesh, spacing=spacing, padding=padding)
    triangles = (mesh.triangles - origin) / spacing
    distance = unsigned_distance_nodes(triangles, shape)
    distance[winding_nodes(triangles, shape) >= 0.5] *= -1
    return ScalarGrid(origin, spacing, distance * spacing)


def grid_around(
    mesh: TriMesh, *, spacing: float, padding: float
) -> tuple[Array, tuple[int, int, int]]:
    """Origin and shape of a grid that covers a mesh and its padding."""
    if not (spacing > 0 and padding >= 0):
        raise BadInput(f"spacing {spacing:g} m and padding {padding:g} m must be positive")
    counts = np.ceil((mesh.extents + 2 * padding) / spacing) + 1
    if not counts.prod() <= MAX_NODES:
        raise BadInput(f"a grid of {counts.prod():.3g} nodes is too fine; use a larger spacing")
    nx, ny, nz = (max(int(count), 2) for count in counts)
    size = (np.array([nx, ny, nz]) - 1) * spacing
    origin: Array = mesh.bounds.mean(axis=0) - size / 2
    return origin, (nx, ny, nz)


def unsigned_distance_nodes(triangles: Array, shape: tuple[int, int, int]) -> Array:
    """Distance of every node of a unit grid to triangles (f, 3, 3) in grid units."""
    distance, nearest = splat_distances(triangles, shape, _BAND_CELLS)
    places = distance_transform_edt(distance > 1, return_distances=False, return_indices=True)
    distances: Array = distances_by_sweeping(triangles, nearest[tuple(places)])
    return distances


def winding_nodes(triangles: Array, shape: tuple[int, int, int]) -> Array:
    """How often the surface wraps each node of a unit grid: 1 inside, 0 outside.

    The mean of the signed crossings along the six axis directions: exact for a closed
    surface, a vote for one with holes.
    """
    total = np.zeros(shape)
    for axes in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turned = np.ascontiguousarray(triangles[:, :, axes])
        crossings = crossings_along_z(turned, (shape[axes[0]], shape[axes[1]], shape[axes[2]]))
        below = crossings.cumsum(axis=2)
        total += (below[:, :, -1:] / 2 - below[:, :, :-1]).transpose(np.argsort(axes))
    return total / 3


def distance_to_surface(mesh: TriMesh, points: Array) -> Array:
    """Unsigned distance of points (n, 3) to the surface [m], exact, (n,)."""
    centers = mesh.triangles.mean(axis=1)
    radii = np.linalg.norm(mesh.triangles - centers[:, None], axis=2).max(axis=1)
    distances: Array = point_distances(
        np.ascontiguousarray(points, dtype=np.float64), mesh.triangles, centers, radii
    )
    return distances


def interpolate(grid: ScalarGrid, points: Array) -> tuple[Array, Array]:
    """Trilinear value and gradient of a grid at points (n, 3): (n,) and (n, 3).

    Outside the grid the value continues from its border, growing with the distance to it, so
    that a signed distance stays positive and points back towards the object.
    """
    values, gradients = _interpolate(
        grid.values, grid.origin, grid.spacing, np.ascontiguousarray(points, dtype=np.float64)
    )
    return values, gradients


@njit(cache=True)
def _interpolate(
    values: Array, origin: Array, spacing: float, points: Array
) -> tuple[Array, Array]:
    result, gradients = np.empty(len(points)), np.empty((len(points), 3))
    cell, t, excess = np.empty(3, np.int64), np.empty(3), np.empty(3)
    for n in range(len(points)):
        for axis in range(3):
            last = values.shape[axis] - 1
            u = (points[n, axis] - origin[axis]) / spacing
            inside = min(max(u, 0.0), float(last))
            excess[axis] = (u - inside) * spacing
            cell[axis] = min(int(inside), last - 1)
            t[axis] = inside - cell[axis]
        result[n] = _blend(values, cell, t, spacing, gradients[n])
        beyond = np.sqrt((excess**2).sum())
        if beyond > 0:
            result[n] += beyond
            gradients[n] = excess / beyond
    return result, gradients


@njit(cache=True)
def _blend(values: Array, cell: IntArray, t: Array, spacing: float, gradient: Array) -> float:
    """Trilinear value in a cell; the gradient is written to its argument."""
    value = 0.0
    gradient[:] = 0.0
    for i in range(2):
        wx, sx = (t[0], 1.0) if i else (1 - t[0], -1.0)
        for j in range(2):
            wy, sy = (t[1], 1.0) if j else (1 - t[1], -1.0)
            for k in range(2):
                wz, sz = (t[2], 1.0) if k else (1 - t[2], -1.0)
                v = values[cell[0] + i, cell[1] + j, cell[2] + k]
                value += wx * wy * wz * v
                gradient[0] += sx * wy * wz * v / spacing
                gradient[1] += wx * sy * wz * v / spacing
                gradient[2] += wx * wy * sz * v / spacing
    return value
