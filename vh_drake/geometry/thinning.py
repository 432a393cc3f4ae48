"""Solids of voxels thinned to lines in their middle.

Voxels are peeled off from one of six sides after the other, as long as they are *simple*: their
removal neither cuts the solid, nor opens or fills a hole of it (Bertrand & Malandain 1994). What is
the end of a line when its turn comes stays. So Lee, Kashyap and Chu (1994) thin too; but here, the
order within a side keeps flat strips of even width from vanishing.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vh_drake.types import IntArray

# A neighbourhood of 3 by 3 by 3 is an integer: bit 9 i + 3 j + k is the voxel (i, j, k) of it.
_CENTER = 13
_OFFSETS = np.stack(np.meshgrid(*[np.arange(-1, 2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def _bits(chosen: NDArray[np.bool_]) -> int:
    return int((1 << np.flatnonzero(chosen)).sum())


def _neighbors(farthest: int) -> IntArray:
    """For each bit the bits of those that share a face (1) or at least a corner (3) with it."""
    steps = _OFFSETS[:, None] - _OFFSETS
    near = (np.abs(steps).max(axis=2) == 1) & (np.abs(steps).sum(axis=2) <= farthest)
    near[:, _CENTER] = False
    return np.array([_bits(row) for row in near], np.int64)


_BY_CORNERS, _BY_FACES = _neighbors(3), _neighbors(1)
_REACH = np.abs(_OFFSETS).sum(axis=1)
_FACES, _EDGES = _bits(_REACH == 1), _bits((_REACH == 1) | (_REACH == 2))


def thinned(solid: NDArray[np.bool_]) -> IntArray:
    """The voxels (n, 3) of lines that are left of a solid; each of its parts keeps some.

    Parts without a direction, such as balls, leave a voxel or two; holes are ringed by loops.
    """
    padded = np.pad(solid, 1).astype(np.uint8)
    voxels = np.argwhere(padded)
    # Every second one of a row first: one after the other, a flat strip would go from its end.
    _peel(padded, voxels[np.argsort(voxels % 2 @ [4, 2, 1], kind="stable")])
    return np.argwhere(padded) - 1


@njit(cache=True)
def _peel(solid: NDArray[np.uint8], voxels: IntArray) -> None:
    """Clear those of the voxels (n, 3) of a padded solid that thinning takes away."""
    changed = True
    while changed:
        changed = False
        for axis in range(3):
            for side in (-1, 1):
                changed |= _peel_side(solid, voxels, axis, side)


@njit(cache=True)
def _peel_side(solid: NDArray[np.uint8], voxels: IntArray, axis: int, side: int) -> bool:
    """Take away what may go of the voxels that are bare on one side."""
    count, chosen = 0, np.empty(len(voxels), np.int64)
    for n in range(len(voxels)):
        i, j, k = voxels[n]
        bare = not solid[i + side * (axis == 0), j + side * (axis == 1), k + side * (axis == 2)]
        if solid[i, j, k] and bare:
            around = _neighborhood(solid, i, j, k)
            is_end = around & (around - 1) == 0  # At most one neighbour
            if not is_end and _is_simple(around):
                chosen[count] = n
                count += 1
    changed = False
    for n in range(count):
        i, j, k = voxels[chosen[n]]
        if _is_simple(_neighborhood(solid, i, j, k)):  # Neighbours may have gone meanwhile.
            solid[i, j, k] = 0
            changed = True
    return changed


@njit(cache=True)
def _neighborhood(solid: NDArray[np.uint8], i: int, j: int, k: int) -> int:
    bits, bit = 0, 1
    for a in range(i - 1, i + 2):
        for b in range(j - 1, j + 2):
            for c in range(k - 1, k + 2):
                bits += bit * solid[a, b, c]
                bit *= 2
    return bits & ~(1 << _CENTER)


@njit(cache=True)
def _is_simple(solid: int) -> bool:
    """Whether the middle of a neighbourhood may go without a change of topology."""
    if solid == 0 or _flooded(solid & -solid, solid, _BY_CORNERS) != solid:
        return False
    empty = ~solid & _EDGES
    faces = empty & _FACES
    return faces != 0 and faces & ~_flooded(faces & -faces, empty, _BY_FACES) == 0


@njit(cache=True)
def _flooded(start: int, allowed: int, neighbors: IntArray) -> int:
    """All bits that are connected to the first ones within the allowed ones."""
    filled, front = start, start
    while front:
        grown = 0
        for bit in range(27):
            if front >> bit & 1:
                grown |= neighbors[bit]
        front = grown & allowed & ~filled
        filled |= front
    return filled
