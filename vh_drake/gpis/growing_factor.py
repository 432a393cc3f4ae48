"""A Cholesky factor that grows by rows without being copied.

Factors that grew from one another share one buffer: the rows that they have in common are the same
memory. Only the first successor of a factor may write below it; a second one (a branch, as of a
strategy that looks ahead) starts a buffer of its own. So every factor stays what it was.
"""

from dataclasses import dataclass
from typing import Self

import numba
import numpy as np

from vh_drake.types import Array, Immutable

_SPARE = 64  # rows of a buffer beyond twice what is needed


@dataclass(eq=False)
class _Buffer:
    entries: Array  # (capacity, capacity)
    used: int  # rows that some factor holds


@dataclass(frozen=True, eq=False)
class GrowingFactor(Immutable):
    """The lower triangular factor L (rows, rows) of a symmetric matrix that gets more rows."""

    _buffer: _Buffer
    rows: int

    @classmethod
    def of(cls, lower: Array) -> Self:
        """A factor that starts with a lower triangular matrix, which it keeps."""
        return cls(_Buffer(lower, len(lower)), len(lower))

    @property
    def lower(self) -> Array:
        """L (rows, rows); what lies above its diagonal has no meaning."""
        return self._buffer.entries[: self.rows, : self.rows]

    def extended(self, side: Array, corner: Array) -> "GrowingFactor":
        """The factor of the matrix with more rows, O(rows²) for each of them.

        Args:
            side: (extra, rows) covariances of the new rows with the old ones.
            corner: (extra, extra) of the new rows among themselves.

        Raises:
            LinAlgError: the larger matrix is not positive definite; this factor stays usable.
        """
        total = self.rows + len(corner)
        buffer = self._room_for(total)
        if not _append_rows(buffer.entries, self.rows, side, corner):
            raise np.linalg.LinAlgError("not positive definite")
        buffer.used = total
        return GrowingFactor(buffer, total)

    def solve(self, y: Array) -> Array:
        """The solution x (rows,) of L Lᵀ x = y."""
        solution: Array = _solve(self._buffer.entries, self.rows, y)
        return solution

    def _room_for(self, total: int) -> _Buffer:
        if self._buffer.used == self.rows and total <= len(self._buffer.entries):
            return self._buffer
        entries = np.empty((2 * total + _SPARE,) * 2)
        entries[: self.rows, : self.rows] = self.lower
        return _Buffer(entries, self.rows)


@numba.njit(cache=True, fastmath={"contract", "reassoc", "nsz"})
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@numba.njit(cache=True, fastmath={"contract", "reassoc", "nsz"})
def _four_dots(a: Array, b: Array) -> tuple[float, float, float, float]:
    """Products of a (n,) with the four rows of b (4, n), for one reading of a."""
    s = t = u = v = 0.0
    for i in range(len(a)):
        s += a[i] * b[0, i]
        t += a[i] * b[1, i]
        u += a[i] * b[2, i]
        v += a[i] * b[3, i]
    return s, t, u, v


@numba.njit(cache=True)
def _forward(L: Array, rows: int, side: Array) -> None:
    """Write (side L⁻ᵀ) below the first rows of L, by four rows at a time where there are four."""
    extra = len(side)
    for e in range(0, extra - extra % 4, 4):
        new = L[rows + e : rows + e + 4]
        for i in range(rows):
            s, t, u, v = _four_dots(L[i, :i], new[:, :i])
            new[0, i] = (side[e, i] - s) / L[i, i]
            new[1, i] = (side[e + 1, i] - t) / L[i, i]
            new[2, i] = (side[e + 2, i] - u) / L[i, i]
            new[3, i] = (side[e + 3, i] - v) / L[i, i]
    for e in range(extra - extra % 4, extra):
        for i in range(rows):
            dot = _dot(L[i, :i], L[rows + e, :i])
            L[rows + e, i] = (side[e, i] - dot) / L[i, i]


@numba.njit(cache=True)
def _append_rows(L: Array, rows: int, side: Array, corner: Array) -> bool:
    """Write the next rows of a factor; False where the matrix is not positive definite."""
    _forward(L, rows, side)
    for e in range(len(corner)):
        new = L[rows + e]
        for i in range(e):
            k = rows + i
            new[k] = (corner[e, i] - _dot(L[k, :k], new[:k])) / L[k, k]
        pivot = corner[e, e] - _dot(new[: rows + e], new[: rows + e])
        if not pivot > 0.0:
            return False
        new[rows + e] = np.sqrt(pivot)
    return True


@numba.njit(cache=True)
def _solve(L: Array, rows: int, y: Array) -> Array:
    x = y.copy()
    for i in range(rows):
        x[i] = (x[i] - _dot(L[i, :i], x[:i])) / L[i, i]
    for i in range(rows - 1, -1, -1):
        x[i] /= L[i, i]
        for j in range(i):  # columns of Lᵀ are rows of L, which lie together in memory
            x[j] -= L[i, j] * x[i]
    return x
