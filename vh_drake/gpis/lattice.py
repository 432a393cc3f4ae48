"""Places of a lattice in a hash table that is small where the lattice is.

A place is the node (i, j, k) and the cell of which this node is the first corner. Its key holds the
three indices side by side, each from -1 on. Small keys are their own slots, so that a lattice up
to the table's size has no collisions and neighbours lie together in memory; of larger keys only
those that are met take room (open addressing).
"""

import numba
import numpy as np

from vh_drake.types import Array, IntArray

EMPTY = -1
FIRST_ROOM = 1 << 15
_DIRECT_BITS = 15  # of keys that are their own slots


def shifts(shape: IntArray) -> IntArray:
    """Where the index of each axis stands in a key (3,), for so many cells a side (3,)."""
    bits = [int(n + 2).bit_length() for n in shape]
    return np.array([bits[1] + bits[2], bits[2], 0], dtype=np.int64)


@numba.njit(cache=True)
def key_of(i: int, j: int, k: int, shift: IntArray) -> int:
    """The key of a place; indices from -1 on."""
    return int((i + 1 << shift[0]) + (j + 1 << shift[1]) + k + 1)


@numba.njit(cache=True)
def indices(key: int, shift: IntArray) -> tuple[int, int, int]:
    """The place of a key."""
    j = key >> shift[1] & (1 << shift[0] - shift[1]) - 1
    return (key >> shift[0]) - 1, j - 1, (key & (1 << shift[1]) - 1) - 1


@numba.njit(cache=True)
def slot_of(keys: IntArray, key: int) -> int:
    """Where a place is in the table, or where it may be put."""
    mask = len(keys) - 1
    slot = (key ^ (key >> _DIRECT_BITS) * 0x9E3779B1) & mask
    while keys[slot] != key and keys[slot] != EMPTY:
        slot = (slot + 1) & mask
    return slot


@numba.njit(cache=True)
def new_table(room: int) -> tuple[IntArray, Array, IntArray]:
    """Keys, potentials (NaN where not evaluated) and vertices (-1 where there is none)."""
    return np.full(room, EMPTY), np.full(room, np.nan), np.full(room, -1)


@numba.njit(cache=True)
def larger_table(
    keys: IntArray, values: Array, vertex: IntArray
) -> tuple[IntArray, Array, IntArray]:
    """The table with twice the room."""
    larger = new_table(2 * len(keys))
    for old in range(len(keys)):
        if keys[old] != EMPTY:
            slot = slot_of(larger[0], keys[old])
            larger[0][slot], larger[1][slot] = keys[old], values[old]
            larger[2][slot] = vertex[old]
    return larger
