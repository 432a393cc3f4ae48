r"""Wrench-space quality of contacts with friction (Ferrari & Canny 1992).

A contact at p with the outward normal n may push along every edge of its friction cone,

.. math:: f = -n + μ (\cos φ \, t_1 + \sin φ \, t_2), \qquad w = (f, (p - c) × f / L),

where c is the object's centre of mass and L its size, which makes torques comparable to
forces. The primitive wrenches w are the columns of the wrench matrix W.
"""

import dataclasses as dc

import numpy as np
from numba import njit
from scipy.spatial import ConvexHull, QhullError

from vh_drake.errors import BadInput
from vh_drake.types import Array, IntArray

_RESIDUAL = 1e-7  # Relative length that counts as none
_RANK = 1e-6  # Relative length of an independent direction


@dc.dataclass
class ContactSettings:
    """How contacts are turned into wrenches."""

    friction: float = 0.8
    edges: int = 8  # of the pyramid inscribed in each friction cone


@dc.dataclass(frozen=True)
class WrenchQuality:
    """Both are 0 where the grasp is not force closed."""

    epsilon: float  # radius of the largest origin-centred ball in the hull of the wrenches
    volume: float  # of that hull


def wrench_matrix(
    p_WC: Array, n_WC: Array, *, center: Array, size_m: float, settings: ContactSettings
) -> Array:
    """Primitive wrenches (6, contacts * edges) of contacts (n, 3) with outward unit normals.

    Raises:
        BadInput: the object's size or the settings are not positive.
    """
    check_contact_settings(settings)
    if not size_m > 0:
        raise BadInput(f"the object's size must be positive; got {size_m:g} m")
    wrenches = np.empty((len(p_WC) * settings.edges, 6))
    p, n = np.ascontiguousarray(p_WC, np.float64), np.ascontiguousarray(n_WC, np.float64)
    fill_wrenches(p, n, center, size_m, settings.friction, settings.edges, wrenches)
    return wrenches.T


def check_contact_settings(settings: ContactSettings) -> None:
    """Raise BadInput where friction or the number of edges can't be used."""
    if not (settings.friction >= 0 and settings.edges >= 3):
        raise BadInput(
            f"friction {settings.friction:g} must not be negative and edges "
            f"({settings.edges}) must be at least 3"
        )


def is_force_closure(W: Array) -> bool:
    """Whether the columns of W (6, n) span all wrenches with positive weights."""
    rows = np.array(W.T, dtype=np.float64, order="C")
    return bool(spans_positively(rows, len(rows)))


def wrench_quality(W: Array) -> WrenchQuality:
    """Exact epsilon and volume of the convex hull of the columns of W (6, n), by Qhull."""
    if not is_force_closure(W):
        return WrenchQuality(0.0, 0.0)
    try:
        hull = ConvexHull(W.T)
    except QhullError:  # Flat within Qhull's tolerance, so without a ball inside.
        return WrenchQuality(0.0, 0.0)
    return WrenchQuality(max(0.0, float(-hull.equations[:, -1].max())), float(hull.volume))


@njit(cache=True)
def fill_wrenches(
    p: Array, n: Array, center: Array, size: float, friction: float, edges: int, result: Array
) -> None:
    """Write the primitive wrenches of contacts (c, 3) as rows of `result` (c * edges, 6)."""
    for c in range(len(p)):
        nx, ny, nz = n[c, 0], n[c, 1], n[c, 2]
        # An orthonormal basis without branches near the poles (Duff et al. 2017).
        sign = 1.0 if nz >= 0 else -1.0
        a = -1.0 / (sign + nz)
        b = nx * ny * a
        t1 = (1.0 + sign * nx * nx * a, sign * b, -sign * nx)
        t2 = (b, sign + ny * ny * a, -ny)
        r = (
            (p[c, 0] - center[0]) / size,
            (p[c, 1] - center[1]) / size,
            (p[c, 2] - center[2]) / size,
        )
        for e in range(edges):
            angle = 2 * np.pi * e / edges
            u, v = friction * np.cos(angle), friction * np.sin(angle)
            fx = -nx + u * t1[0] + v * t2[0]
            fy = -ny + u * t1[1] + v * t2[1]
            fz = -nz + u * t1[2] + v * t2[2]
            row = result[c * edges + e]
            row[0], row[1], row[2] = fx, fy, fz
            row[3] = r[1] * fz - r[2] * fy
            row[4] = r[2] * fx - r[0] * fz
            row[5] = r[0] * fy - r[1] * fx


@njit(cache=True)
def spans_positively(rows: Array, count: int) -> bool:
    r"""Whether the first rows (n, 6) span the space with positive weights.

    True iff the rank is 6 and, for some strictly positive weights c, the wrench -Σ c_i w_i is
    a non-negative combination of the rows. The latter is a non-negative least-squares problem
    (Lawson & Hanson 1974, algorithm 23.10) whose residual must vanish. Weights that differ
    from row to row keep the problem non-degenerate, so that usually six active rows prove
    the rank on the way.
    """
    if count < 7:
        return False
    target = np.zeros(6)
    for i in range(count):
        weight = 1.0 + (0.618034 * i) % 1.0
        for k in range(6):
            target[k] -= weight * rows[i, k]
    active = _solve_nonnegative(rows, count, target)
    if active == 6:
        return True
    return active >= 0 and _rank(rows, count) == 6


@njit(cache=True)
def _solve_nonnegative(rows: Array, count: int, target: Array) -> int:
    """Number of active rows whose non-negative combination is the target, -1 where none is."""
    active, weights, solution = np.empty(7, np.int64), np.zeros(7), np.zeros(7)
    Q, R = np.empty((7, 6)), np.empty((7, 7))
    residual = target.copy()
    limit = _RESIDUAL * np.sqrt(dot(target, target))
    num = 0
    for _ in range(20 + count):
        length = np.sqrt(dot(residual, residual))
        if length <= limit:
            return num
        best = steepest(rows, count, residual)
        if dot(rows[best], residual) <= _RESIDUAL * length or num == 6:
            return -1
        active[num], weights[num] = best, 0.0
        num = _descend(rows, target, active, weights, solution, num + 1, Q, R)
        for k in range(6):
            residual[k] = target[k]
            for i in range(num):
                residual[k] -= weights[i] * rows[active[i], k]
    return -1


@njit(cache=True)
def steepest(rows: Array, count: int, direction: Array) -> int:
    """Which of the first rows (n, 6) reaches farthest along a direction (6,)."""
    best, value = 0, -np.inf
    for i in range(count):
        slope = dot(rows[i], direction)
        if slope > value:
            best, value = i, slope
    return best


@njit(cache=True)
def _descend(
    rows: Array,
    target: Array,
    active: IntArray,
    weights: Array,
    solution: Array,
    num: int,
    Q: Array,
    R: Array,
) -> int:
    """Move the weights to the least-squares solution, dropping rows that would turn negative."""
    start = num - 1
    while num > 0:
        _least_squares(rows, target, active, start, num, Q, R, solution)
        step, blocking = 1.0, -1
        for i in range(num):
            if solution[i] <= 0:
                ratio = weights[i] / (weights[i] - solution[i]) if weights[i] > 0 else 0.0
                if ratio < step:
                    step, blocking = ratio, i
        for i in range(num):
            weights[i] += step * (solution[i] - weights[i])
        if blocking < 0:
            break
        for i in range(blocking, num - 1):
            active[i], weights[i] = active[i + 1], weights[i + 1]
        num -= 1
        start = blocking
    return num


@njit(cache=True)
def _least_squares(
    rows: Array,
    target: Array,
    active: IntArray,
    start: int,
    num: int,
    Q: Array,
    R: Array,
    solution: Array,
) -> None:
    """Solve Σ solution_i rows_active_i ≈ target by modified Gram-Schmidt, from row `start` on."""
    for i in range(start, num):
        for k in range(6):
            Q[i, k] = rows[active[i], k]
        for j in range(i):
            R[j, i] = dot(Q[j], Q[i])
            for k in range(6):
                Q[i, k] -= R[j, i] * Q[j, k]
        R[i, i] = max(np.sqrt(dot(Q[i], Q[i])), 1e-12)
        for k in range(6):
            Q[i, k] /= R[i, i]
    for i in range(num - 1, -1, -1):
        value = dot(Q[i], target)
        for j in range(i + 1, num):
            value -= R[i, j] * solution[j]
        solution[i] = value / R[i, i]


@njit(cache=True)
def _rank(rows: Array, count: int) -> int:
    """Rank by Gram-Schmidt with pivoting; overwrites the rows."""
    for rank in range(6):
        best, value = -1, _RANK**2
        for i in range(count):
            length = dot(rows[i], rows[i])
            if length > value:
                best, value = i, length
        if best < 0:
            return rank
        pivot = rows[best] / np.sqrt(value)
        for i in range(count):
            along = dot(rows[i], pivot)
            for k in range(6):
                rows[i, k] -= along * pivot[k]
    return 6


@njit(cache=True)
def dot(u: Array, v: Array) -> float:
    """The scalar product of two (6,), without a call of BLAS."""
    total: float = u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
    total += u[3] * v[3] + u[4] * v[4] + u[5] * v[5]
    return total
