"""The point of a mesh that is nearest to another point, by a tree of boxes."""

from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.geometry.meshes import TriMesh
from vh_drake.types import Array, IntArray

Vector = tuple[float, float, float]

_LEAF_TRIANGLES = 4
_DEPTH = 64  # of the stack: far more than a tree of any mesh that fits into memory needs


class TriangleTree(NamedTuple):
    """Triangles in boxes in boxes; node 0 holds all.

    Attributes:
        low: (n, 3) least corner of each node's box [m].
        high: (n, 3) greatest corner [m].
        first: (n,) the first triangle of a leaf, or the first of two children that follow
            each other.
        number: (n,) triangles of a leaf; 0 where the node has children.
        triangles: (f, 3, 3) corners, in the order of the leaves [m].
        faces: (f,) which of the mesh's faces they are.
    """

    low: Array
    high: Array
    first: IntArray
    number: IntArray
    triangles: Array
    faces: IntArray


def triangle_tree(mesh: TriMesh) -> TriangleTree:
    """The tree of a mesh's triangles.

    Each node is halved at the median of its triangles' centres along the longest side.
    """
    centres = mesh.triangles.mean(axis=1)
    order = np.arange(len(centres), dtype=np.int64)
    first, count = [0], [len(centres)]
    spans = [(0, len(centres))]
    node = 0
    while node < len(spans):
        start, end = spans[node]
        if end - start > _LEAF_TRIANGLES:
            own = order[start:end]
            axis = int(np.argmax(np.ptp(centres[own], axis=0)))
            order[start:end] = own[np.argsort(centres[own, axis], kind="stable")]
            middle = (start + end) // 2
            first[node], count[node] = len(spans), 0
            spans += [(start, middle), (middle, end)]
            first += [start, middle]
            count += [middle - start, end - middle]
        node += 1
    triangles = np.ascontiguousarray(mesh.triangles[order])
    low = np.array([triangles[a:b].min(axis=(0, 1)) for a, b in spans])
    high = np.array([triangles[a:b].max(axis=(0, 1)) for a, b in spans])
    return TriangleTree(low, high, np.array(first), np.array(count), triangles, order)


@njit(cache=True)
def _box_distance2(low: Array, high: Array, node: int, p: Vector) -> float:
    total = 0.0
    for axis in range(3):
        out = max(low[node, axis] - p[axis], p[axis] - high[node, axis], 0.0)
        total += out * out
    return total


@njit(cache=True, inline="always")
def _dot(u: Vector, v: Vector) -> float:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@njit(cache=True, inline="always")
def _along(a: Vector, u: Vector, s: float) -> Vector:
    return (a[0] + s * u[0], a[1] + s * u[1], a[2] + s * u[2])


@njit(cache=True)
def _on_segment(p: Vector, a: Vector, b: Vector) -> Vector:
    ab = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    ap = (p[0] - a[0], p[1] - a[1], p[2] - a[2])
    length = _dot(ab, ab)
    share = min(max(_dot(ap, ab) / length, 0.0), 1.0) if length > 0.0 else 0.0
    return _along(a, ab, share)


@njit(cache=True)
def _distance2(p: Vector, q: Vector) -> float:
    return (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2


@njit(cache=True)
def closest_on_triangle(p: Vector, a: Vector, b: Vector, c: Vector) -> Vector:
    """The point of a triangle nearest to p: its foot in the plane, or on the nearest edge."""
    ab = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    ac = (c[0] - a[0], c[1] - a[1], c[2] - a[2])
    ap = (p[0] - a[0], p[1] - a[1], p[2] - a[2])
    d00, d01, d11 = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    d20, d21 = _dot(ap, ab), _dot(ap, ac)
    area2 = d00 * d11 - d01 * d01
    v, w = d11 * d20 - d01 * d21, d00 * d21 - d01 * d20
    if area2 > 0.0 and v >= 0.0 and w >= 0.0 and v + w <= area2:
        return _along(_along(a, ab, v / area2), ac, w / area2)
    best = _on_segment(p, a, b)
    for q in (_on_segment(p, b, c), _on_segment(p, c, a)):
        if _distance2(p, q) < _distance2(p, best):
            best = q
    return best


@njit(cache=True)
def _corner(triangles: Array, face: int, corner: int) -> Vector:
    return (triangles[face, corner, 0], triangles[face, corner, 1], triangles[face, corner, 2])


@njit(cache=True)
def closest_point(tree: TriangleTree, p: Vector, within: float) -> tuple[float, Vector]:
    """Distance to the mesh and its nearest point; (within, p) where nothing is nearer.

    Args:
        tree: of the mesh.
        p: anywhere [m].
        within: farther triangles don't matter [m].
    """
    distance, nearest, _ = _closest(tree, p, within)
    return distance, nearest


@njit(cache=True)
def _closest(tree: TriangleTree, p: Vector, within: float) -> tuple[float, Vector, int]:
    """As `closest_point`, and which of the tree's triangles holds it; -1 where none is near."""
    best2, best, face = within * within, p, -1
    stack = np.empty(_DEPTH, np.int64)
    stack[0], size = 0, 1
    while size > 0:
        size -= 1
        node = stack[size]
        if _box_distance2(tree.low, tree.high, node, p) >= best2:
            continue
        start = tree.first[node]
        if tree.number[node] == 0:
            near, far = start, start + 1
            if _box_distance2(tree.low, tree.high, far, p) < _box_distance2(
                tree.low, tree.high, near, p
            ):
                near, far = far, near
            stack[size], stack[size + 1] = far, near
            size += 2
            continue
        for f in range(start, start + tree.number[node]):
            corners = tree.triangles
            q = closest_on_triangle(
                p, _corner(corners, f, 0), _corner(corners, f, 1), _corner(corners, f, 2)
            )
            d2 = _distance2(p, q)
            if d2 < best2:
                best2, best, face = d2, q, f
    return np.sqrt(best2), best, face


def closest_points(tree: TriangleTree, points: Array) -> Array:
    """The nearest points (n, 3) of the mesh to points (n, 3) [m]."""
    return closest_faces(tree, points)[0]


def closest_faces(tree: TriangleTree, points: Array) -> tuple[Array, IntArray]:
    """The nearest points (n, 3) [m], and the faces (n,) of the mesh that hold them.

    A point of an edge belongs to either face.
    """
    nearest, found = _closest_to_each(tree, points)
    return nearest, tree.faces[found]


@njit(cache=True)
def _closest_to_each(tree: TriangleTree, points: Array) -> tuple[Array, IntArray]:
    nearest, found = np.empty_like(points), np.empty(len(points), np.int64)
    for i in range(len(points)):
        p = (points[i, 0], points[i, 1], points[i, 2])
        _, q, found[i] = _closest(tree, p, np.inf)
        nearest[i, 0], nearest[i, 1], nearest[i, 2] = q
    return nearest, found
