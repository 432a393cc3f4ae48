"""Compiled loops over triangles: distances to points and grids, crossings of grid lines."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vh_drake.types import Array, IntArray

Vector = tuple[float, float, float]


@njit(cache=True)
def _minus(u: Vector, v: Vector) -> Vector:
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


@njit(cache=True)
def _dot(u: Vector, v: Vector) -> float:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@njit(cache=True)
def _to_segment(u: Vector, v: Vector) -> float:
    """Squared distance of u to the segment from 0 to v."""
    length = _dot(v, v)
    t = min(max(_dot(u, v) / length, 0.0), 1.0) if length > 0 else 0.0
    w = (u[0] - t * v[0], u[1] - t * v[1], u[2] - t * v[2])
    return _dot(w, w)


@njit(cache=True)
def _corner(triangles: Array, face: int, corner: int) -> Vector:
    return (
        triangles[face, corner, 0],
        triangles[face, corner, 1],
        triangles[face, corner, 2],
    )


@njit(cache=True)
def squared_distance(p: Vector, a: Vector, b: Vector, c: Vector) -> float:
    """Squared distance from a point to a triangle, by regions (Ericson 2005, section 5.1.5)."""
    ab, ac = _minus(b, a), _minus(c, a)
    ap, bp, cp = _minus(p, a), _minus(p, b), _minus(p, c)
    d1, d2 = _dot(ab, ap), _dot(ac, ap)
    d3, d4 = _dot(ab, bp), _dot(ac, bp)
    d5, d6 = _dot(ab, cp), _dot(ac, cp)
    if d1 <= 0 and d2 <= 0:
        return _dot(ap, ap)
    if d3 >= 0 and d4 <= d3:
        return _dot(bp, bp)
    if d6 >= 0 and d5 <= d6:
        return _dot(cp, cp)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        return _to_segment(ap, ab)
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        return _to_segment(ap, ac)
    if va <= 0 and d4 >= d3 and d5 >= d6:
        return _to_segment(bp, _minus(c, b))
    total = va + vb + vc
    if not total > 0:  # no area: one of its edges is nearest
        return min(_to_segment(ap, ab), _to_segment(ap, ac), _to_segment(bp, _minus(c, b)))
    v, w = vb / total, vc / total
    q = (
        ap[0] - v * ab[0] - w * ac[0],
        ap[1] - v * ab[1] - w * ac[1],
        ap[2] - v * ab[2] - w * ac[2],
    )
    return _dot(q, q)


@njit(cache=True)
def point_distances(points: Array, triangles: Array, centers: Array, radii: Array) -> Array:
    """Distance of each point (n, 3) to the nearest triangle, which a ball bounds, (n,)."""
    result = np.empty(len(points))
    for i in range(len(points)):
        p = (points[i, 0], points[i, 1], points[i, 2])
        best = np.inf
        for f in range(len(triangles)):
            d = _minus(p, (centers[f, 0], centers[f, 1], centers[f, 2]))
            reach = best + radii[f]
            if _dot(d, d) < reach * reach:
                squared = squared_distance(
                    p, _corner(triangles, f, 0), _corner(triangles, f, 1), _corner(triangles, f, 2)
                )
                best = min(best, np.sqrt(squared))
        result[i] = best
    return result


@njit(cache=True)
def splat_distances(
    triangles: Array, shape: tuple[int, int, int], band: int
) -> tuple[Array, IntArray]:
    """Unsigned distances at the nodes of a unit grid, where a triangle's box comes near.

    Args:
        triangles: Corners in grid units, (f, 3, 3).
        shape: Number of nodes along each axis.
        band: How many cells around each triangle's box are filled.

    Returns:
        Distance (inf where no triangle is near) and index of the nearest triangle (else -1).
    """
    distance = np.full(shape, np.inf)
    nearest = np.full(shape, -1, np.int64)
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for f in range(len(triangles)):
        for axis in range(3):
            column = triangles[f, :, axis]
            low[axis] = max(0, int(np.floor(column.min())) - band)
            high[axis] = min(shape[axis] - 1, int(np.ceil(column.max())) + band)
        a, b, c = _corner(triangles, f, 0), _corner(triangles, f, 1), _corner(triangles, f, 2)
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                for k in range(low[2], high[2] + 1):
                    d = squared_distance((float(i), float(j), float(k)), a, b, c)
                    if d < distance[i, j, k]:
                        distance[i, j, k] = d
                        nearest[i, j, k] = f
    return np.sqrt(distance), nearest


@njit(cache=True)
def _node_distance(triangles: Array, f: int, i: int, j: int, k: int) -> float:
    node = (float(i), float(j), float(k))
    a, b, c = _corner(triangles, f, 0), _corner(triangles, f, 1), _corner(triangles, f, 2)
    return np.sqrt(squared_distance(node, a, b, c))


@njit(cache=True)
def distances_by_sweeping(triangles: Array, nearest: IntArray) -> Array:
    """Distance at each node of a unit grid, from a first guess of the nearest triangles.

    Each node adopts the triangle of a neighbour where that one is nearer, in one sweep
    forwards and one backwards. The guesses are updated in place.
    """
    nx, ny, nz = nearest.shape
    distance = np.empty(nearest.shape)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                distance[i, j, k] = _node_distance(triangles, nearest[i, j, k], i, j, k)
    for backwards in range(2):
        step = -1 if backwards else 1
        for n in range(nx * ny * nz):
            m = nx * ny * nz - 1 - n if backwards else n
            i, j, k = m // (ny * nz), m // nz % ny, m % nz
            for axis in range(3):
                u, v, w = i - step * (axis == 0), j - step * (axis == 1), k - step * (axis == 2)
                if 0 <= u < nx and 0 <= v < ny and 0 <= w < nz:
                    f = nearest[u, v, w]
                    d = _node_distance(triangles, f, i, j, k) if f != nearest[i, j, k] else np.inf
                    if d < distance[i, j, k]:
                        distance[i, j, k] = d
                        nearest[i, j, k] = f
    return distance


@njit(cache=True)
def _side(a: Vector, b: Vector, x: float, y: float) -> float:
    """Twice the signed area of (a, b, point) in the plane, exactly antisymmetric in a and b."""
    if (a[0], a[1]) > (b[0], b[1]):
        return -((a[0] - b[0]) * (y - b[1]) - (a[1] - b[1]) * (x - b[0]))
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])


@njit(cache=True)
def crossings_along_z(triangles: Array, shape: tuple[int, int, int]) -> NDArray[np.int32]:
    """Signed crossings of the grid lines along z with triangles in grid units.

    Entry (i, j, k) holds the upward minus the downward facing triangles that line (i, j)
    crosses between nodes k - 1 and k; entry nz those beyond the last node.
    """
    shift = 1.234567e-6  # lines pass beside vertices that lie on nodes
    crossings = np.zeros((shape[0], shape[1], shape[2] + 1), np.int32)
    for f in range(len(triangles)):
        a, b, c = _corner(triangles, f, 0), _corner(triangles, f, 1), _corner(triangles, f, 2)
        i_low = max(0, int(np.ceil(min(a[0], b[0], c[0]) - shift)))
        i_high = min(shape[0] - 1, int(np.floor(max(a[0], b[0], c[0]) - shift)))
        j_low = max(0, int(np.ceil(min(a[1], b[1], c[1]) - 2 * shift)))
        j_high = min(shape[1] - 1, int(np.floor(max(a[1], b[1], c[1]) - 2 * shift)))
        for i in range(i_low, i_high + 1):
            for j in range(j_low, j_high + 1):
                x, y = i + shift, j + 2 * shift
                wa, wb, wc = _side(b, c, x, y), _side(c, a, x, y), _side(a, b, x, y)
                if (wa > 0) == (wb > 0) and (wb > 0) == (wc > 0) and wa + wb + wc != 0:
                    z = (wa * a[2] + wb * b[2] + wc * c[2]) / (wa + wb + wc)
                    k = min(max(int(np.floor(z)) + 1, 0), shape[2])
                    crossings[i, j, k] += 1 if wa > 0 else -1
    return crossings
