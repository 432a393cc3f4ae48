r"""Epsilon quality, exact, without the whole convex hull (Ferrari & Canny 1992).

Epsilon is the least distance of a facet of the wrenches' hull from the origin. Only facets near
the origin matter, so that the hull is built from inside (after Zheng 2013): the nearest facet of
a polytope within the hull is asked how far the wrenches reach along its normal (the support
function). Where none lies beyond it, it is a facet of the hull, and the nearest; else the
farthest wrench joins the polytope, and the next nearest facet is asked.

=========  ==============================================================
symbol     meaning
=========  ==============================================================
w          (n, 6) wrenches, one a row
n, d       unit normal and offset of a facet, n . w <= d for what it holds
ε          min d over the facets of the hull
=========  ==============================================================

Degenerate case: wrenches in a hyperplane have ε = 0.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.errors import BadInput
from vh_drake.grasping.wrench_space import dot, is_force_closure, steepest
from vh_drake.types import Array, IntArray

_FLAT = 1e-10  # height over a facet that counts as none, for wrenches of length 1
_BITS = 10  # of a wrench's index in the key of a ridge
_MOST = (1 << _BITS) - 1


class _Facets(NamedTuple):
    """Simplicial facets of a polytope, the first `count` of each array."""

    vertices: IntArray  # (f, 6) rising indices of wrenches
    normal: Array  # (f, 6) outward unit normals
    offset: Array  # (f,)


def epsilon_quality(W: Array) -> float:
    """Radius of the largest origin-centred ball in the hull of the columns of W (6, n).

    0 where the grasp is not force closed. The same as `wrench_quality` tells, which computes
    the whole hull for its volume and takes many times longer.

    Raises:
        BadInput: more than 1023 wrenches.
    """
    if W.shape[1] > _MOST:
        raise BadInput(f"{W.shape[1]} wrenches; take fewer edges a cone, for at most {_MOST}")
    if not is_force_closure(W):
        return 0.0
    rows = np.array(W.T, dtype=np.float64, order="C")
    length = float(np.linalg.norm(rows, axis=1).max())
    return max(0.0, length * float(_least_offset(rows / length)))


@njit(cache=True)
def _least_offset(rows: Array) -> float:
    """Least offset of a facet of the hull of rows (n, 6); 0 where they lie in a hyperplane."""
    simplex = _independent(rows)
    if len(simplex) < 7:
        return 0.0
    facets = _reserve(64)
    inside = np.zeros(6)
    for i in simplex:
        inside += rows[i] / 7
    for left_out in range(7):
        vertices = np.sort(np.delete(simplex, left_out))
        _write(rows, vertices, inside, facets, left_out)
    count = 7
    for _ in range(len(rows) + 1):
        nearest = int(np.argmin(facets.offset[:count]))
        farthest = steepest(rows, len(rows), facets.normal[nearest])
        if dot(rows[farthest], facets.normal[nearest]) <= facets.offset[nearest] + _FLAT:
            break
        facets, count = _join(rows, farthest, inside, facets, count)
    return float(facets.offset[:count].min())


@njit(cache=True)
def _reserve(capacity: int) -> _Facets:
    return _Facets(np.zeros((capacity, 6), np.int64), np.zeros((capacity, 6)), np.zeros(capacity))


@njit(cache=True)
def _independent(rows: Array) -> IntArray:
    """Seven rows (n, 6) that span a simplex, each far from the span of those before it."""
    chosen = np.zeros(7, np.int64)
    rest = rows - rows[0]
    for k in range(1, 7):
        length = (rest * rest).sum(axis=1)
        best = int(np.argmax(length))
        if length[best] <= _FLAT:
            return chosen[:k]
        chosen[k] = best
        pivot = rest[best] / np.sqrt(length[best])
        for i in range(len(rest)):
            rest[i] -= (rest[i] @ pivot) * pivot
    return chosen


@njit(cache=True)
def _join(rows: Array, new: int, inside: Array, facets: _Facets, count: int) -> tuple[_Facets, int]:
    """Facets of the hull of a polytope and one more row (beneath-beyond), and their number.

    Facets that the row sees go; the rim of what it sees, ridges of one such facet alone, is
    joined to it.
    """
    keys, seen, kept = np.empty(6 * count, np.int64), 0, 0
    for f in range(count):
        if dot(rows[new], facets.normal[f]) > facets.offset[f] + _FLAT:
            for left_out in range(6):
                keys[seen] = _key(facets.vertices[f], left_out)
                seen += 1
        else:
            facets.vertices[kept] = facets.vertices[f]
            facets.normal[kept] = facets.normal[f]
            facets.offset[kept] = facets.offset[f]
            kept += 1
    keys = np.sort(keys[:seen])
    facets = _grown(facets, kept, seen)
    vertices = np.empty(6, np.int64)
    for i in range(seen):
        if (i > 0 and keys[i - 1] == keys[i]) or (i + 1 < seen and keys[i + 1] == keys[i]):
            continue
        _unpack(keys[i], vertices)
        vertices[5] = new
        _write(rows, np.sort(vertices), inside, facets, kept)
        kept += 1
    return facets, kept


@njit(cache=True)
def _grown(facets: _Facets, count: int, more: int) -> _Facets:
    """The same facets with room for more."""
    if count + more <= len(facets.offset):
        return facets
    larger = _reserve(2 * (count + more))
    larger.vertices[:count] = facets.vertices[:count]
    larger.normal[:count] = facets.normal[:count]
    larger.offset[:count] = facets.offset[:count]
    return larger


@njit(cache=True)
def _key(vertices: IntArray, left_out: int) -> int:
    """A number that tells a ridge: the vertices (6,) of a facet but for one."""
    key = 0
    for i in range(6):
        if i != left_out:
            key = (key << _BITS) | vertices[i]
    return key


@njit(cache=True)
def _unpack(key: int, vertices: IntArray) -> None:
    """Write the five vertices of a ridge."""
    for i in range(5):
        vertices[4 - i] = key & _MOST
        key >>= _BITS


@njit(cache=True)
def _write(rows: Array, vertices: IntArray, inside: Array, facets: _Facets, f: int) -> None:
    """Fill facet f with the hyperplane through six rows, the inner point beneath it."""
    normal = _normal(rows, vertices)
    offset = dot(normal, rows[vertices[0]])
    sign = 1.0 if dot(normal, inside) <= offset else -1.0
    facets.vertices[f] = vertices
    facets.normal[f] = sign * normal
    facets.offset[f] = sign * offset


@njit(cache=True)
def _normal(rows: Array, vertices: IntArray) -> Array:
    """Unit normal of the hyperplane through six rows, by elimination with full pivoting."""
    A, order = np.empty((5, 6)), np.arange(6)
    for i in range(5):
        A[i] = rows[vertices[i + 1]] - rows[vertices[0]]
    for k in range(5):
        best_row, best_column, largest = k, k, -1.0
        for i in range(k, 5):
            for j in range(k, 6):
                if abs(A[i, j]) > largest:
                    best_row, best_column, largest = i, j, abs(A[i, j])
        for j in range(6):
            A[k, j], A[best_row, j] = A[best_row, j], A[k, j]
        for i in range(5):
            A[i, k], A[i, best_column] = A[i, best_column], A[i, k]
        order[k], order[best_column] = order[best_column], order[k]
        for i in range(k + 1, 5):
            factor = A[i, k] / A[k, k] if largest > 0.0 else 0.0
            for j in range(k, 6):
                A[i, j] -= factor * A[k, j]
    solution, normal = np.zeros(6), np.zeros(6)
    solution[5] = 1.0
    for i in range(4, -1, -1):
        total = 0.0
        for j in range(i + 1, 6):
            total += A[i, j] * solution[j]
        solution[i] = -total / A[i, i] if A[i, i] != 0.0 else 0.0
    for i in range(6):
        normal[order[i]] = solution[i]
    return normal / np.sqrt(dot(normal, normal))
