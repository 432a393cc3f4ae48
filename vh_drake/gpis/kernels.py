r"""Radial covariance functions and their derivative blocks (section 3.2.3, with its errata).

A radial kernel :math:`k(x_i, x_j) = \varphi(d)` with :math:`r = x_i - x_j`, :math:`d = |r|` needs
three scalars for every block of the extended covariance matrix (eq. 3.28):

.. math::

    \varphi(d), \qquad g(d) = \varphi'(d) / d, \qquad h(d) = g'(d) / d

.. math::

    \operatorname{cov}(f_i, f_j) = \varphi, \quad
    \operatorname{cov}(\partial_n f_i, f_j) = r_n g, \quad
    \operatorname{cov}(f_i, \partial_m f_j) = -r_m g, \quad
    \operatorname{cov}(\partial_n f_i, \partial_m f_j) = -(\delta_{nm} g + r_n r_m h)

===================  =======================  ===============================
paper                code                     meaning
===================  =======================  ===============================
:math:`\sigma`       ``length``               length scale of eq. 3.41
:math:`R`            ``length``               radius of the thin plate, 3.44
:math:`K^+`          ``covariance_matrix``    eq. 3.28, 3.29
===================  =======================  ===============================

Both kernels are normalised to :math:`k(x, x) = s^2` with the signal's standard deviation s.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numba
import numpy as np

from vh_drake.types import Array, IntArray

FASTMATH = {"contract", "reassoc", "arcp", "nsz"}  # sums over points may be reordered
SQUARED_EXPONENTIAL = 0
THIN_PLATE = 1


class Kernel(Protocol):
    """What the posterior needs to know of a kernel; lengths in metres."""

    @property
    def code(self) -> int:
        """Which profile the compiled loops evaluate."""

    @property
    def length_m(self) -> float:
        """Length scale or radius [m]."""

    @property
    def signal_std_m(self) -> float:
        """Prior standard deviation of the potential [m]."""


@dataclass(frozen=True)
class SquaredExponential:
    """The kernel of eq. 3.41: forgets what is farther than a few length scales."""

    length_m: float = 0.06
    signal_std_m: float = 0.01
    code: int = SQUARED_EXPONENTIAL


@dataclass(frozen=True)
class ThinPlate:
    """The kernel of eq. 3.44 with a constant radius, so that updates of the factor stay valid.

    The radius has to be at least 1.2 times the largest distance between observations.
    The default signal gives gradients a prior standard deviation of one.
    """

    length_m: float = 1.0
    signal_std_m: float = 1.0 / math.sqrt(6.0)
    code: int = THIN_PLATE


@numba.njit(cache=True, inline="always")
def radial_profile(
    code: int, d2: float, length: float, signal2: float
) -> tuple[float, float, float]:
    """The scalars φ, g and h of a kernel at the squared distance d2."""
    if code == SQUARED_EXPONENTIAL:
        inverse = 1.0 / (length * length)
        phi = signal2 * math.exp(-0.5 * d2 * inverse)
        return phi, -phi * inverse, phi * inverse * inverse
    d = math.sqrt(d2)
    unit = signal2 / length**3
    phi = unit * (2.0 * d2 * d - 3.0 * length * d2 + length**3)
    h = 6.0 * unit / d if d > 0.0 else 0.0  # r_n r_m h vanishes with d
    return phi, 6.0 * unit * (d - length), h


@numba.njit(cache=True)
def _fill_block(
    K: Array, i: int, j: int, r: Array, phi: float, g: float, h: float, grad_i: bool, grad_j: bool
) -> None:
    """Write the block of eq. 3.28 whose upper left entry is K[i, j]."""
    K[i, j] = phi
    for m in range(3):
        if grad_j:
            K[i, j + 1 + m] = -r[m] * g
        if grad_i:
            K[i + 1 + m, j] = r[m] * g
            if grad_j:
                for n in range(3):
                    K[i + 1 + n, j + 1 + m] = -r[n] * r[m] * h
                K[i + 1 + m, j + 1 + m] -= g


@numba.njit(cache=True)
def covariance_matrix(
    code: int,
    length: float,
    signal2: float,
    p: Array,
    start_p: IntArray,
    q: Array,
    start_q: IntArray,
) -> Array:
    """Covariance of the observations at points p with those at points q.

    Args:
        code: the kernel's code.
        length: its length scale or radius, in the unit of the points.
        signal2: its variance at distance zero.
        p: (n, 3) points.
        start_p: (n + 1,) first row of each point: one row (the value) or four (value and
            gradient) a point, as eq. 3.35 interleaves them.
        q: (m, 3) points.
        start_q: (m + 1,) first column of each point.

    Returns:
        (start_p[-1], start_q[-1]) matrix.
    """
    K = np.empty((start_p[-1], start_q[-1]))
    r = np.empty(3)
    for i in range(len(p)):
        grad_i = start_p[i + 1] - start_p[i] == 4
        for j in range(len(q)):
            r[0], r[1], r[2] = p[i, 0] - q[j, 0], p[i, 1] - q[j, 1], p[i, 2] - q[j, 2]
            d2 = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
            phi, g, h = radial_profile(code, d2, length, signal2)
            grad_j = start_q[j + 1] - start_q[j] == 4
            _fill_block(K, start_p[i], start_q[j], r, phi, g, h, grad_i, grad_j)
    return K


@numba.njit(cache=True, fastmath=FASTMATH)
def _thin_plate_sum(
    length: float, unit: float, x: float, y: float, z: float, columns: Array
) -> tuple[float, float, float, float]:
    """Eq. 3.36 and its gradient at one point, with unit = signal2 / R³."""
    f = fx = fy = fz = 0.0
    for i in range(columns.shape[1]):
        rx, ry, rz = x - columns[0, i], y - columns[1, i], z - columns[2, i]
        w0, w1, w2, w3 = columns[3, i], columns[4, i], columns[5, i], columns[6, i]
        d2 = rx * rx + ry * ry + rz * rz
        d = math.sqrt(d2)
        slope = rx * w1 + ry * w2 + rz * w3
        g = 6.0 * (d - length)
        f += w0 * (d2 * (2.0 * d - 3.0 * length) + length * length * length) - g * slope
        along = w0 * g - 6.0 * slope / max(d, 1e-150)
        fx += rx * along - g * w1
        fy += ry * along - g * w2
        fz += rz * along - g * w3
    return unit * f, unit * fx, unit * fy, unit * fz


@numba.njit(cache=True, fastmath=FASTMATH)
def _squared_exponential_sum(
    length: float, signal2: float, x: float, y: float, z: float, columns: Array
) -> tuple[float, float, float, float]:
    """Eq. 3.36 and its gradient at one point."""
    inverse = 1.0 / (length * length)
    f = fx = fy = fz = 0.0
    for i in range(columns.shape[1]):
        rx, ry, rz = x - columns[0, i], y - columns[1, i], z - columns[2, i]
        d2 = rx * rx + ry * ry + rz * rz
        phi = math.exp(-0.5 * d2 * inverse)
        w1, w2, w3 = columns[4, i] * inverse, columns[5, i] * inverse, columns[6, i] * inverse
        value = columns[3, i] + rx * w1 + ry * w2 + rz * w3
        f += phi * value
        fx += phi * (w1 - inverse * rx * value)
        fy += phi * (w2 - inverse * ry * value)
        fz += phi * (w3 - inverse * rz * value)
    return signal2 * f, signal2 * fx, signal2 * fy, signal2 * fz


@numba.njit(cache=True)
def weighted_sum(code: int, length: float, signal2: float, x: Array, columns: Array) -> Array:
    """Potential and gradient of eq. 3.36, (m, 4), at points x (m, 3).

    Args:
        code: the kernel's code.
        length: its length scale or radius, in the unit of the points.
        signal2: its variance at distance zero.
        x: (m, 3) points.
        columns: (7, n) coordinates and weights of the observed points; the weights of a gradient
            that was not observed are zero.
    """
    result = np.empty((len(x), 4))
    for a in range(len(x)):
        result[a] = point_sum(code, length, signal2, x[a, 0], x[a, 1], x[a, 2], columns)
    return result


@numba.njit(cache=True)
def point_sum(
    code: int, length: float, signal2: float, x: float, y: float, z: float, columns: Array
) -> tuple[float, float, float, float]:
    """As `weighted_sum`, at one point."""
    if code == SQUARED_EXPONENTIAL:
        return _squared_exponential_sum(length, signal2, x, y, z, columns)
    return _thin_plate_sum(length, signal2 / length**3, x, y, z, columns)


@numba.njit(cache=True, fastmath=FASTMATH)
def plane_factors(ex: Array, ey: Array, along_x: Array, along_y: Array, along_z: Array) -> Array:
    """The factors (nx * ny, 2n) of a squared exponential in the planes of a grid.

    Those of a plane's node are what stands before exp(z) and before z exp(z) in the potential,
    for each of n observed points.

    Args:
        ex: (nx, n) exponentials along x.
        ey: (ny, n) exponentials along y.
        along_x: (nx, n) ex times the weight of value and of slope along x.
        along_y: (ny, n) slope along y.
        along_z: (n,) weight of the slope along z.
    """
    nx, ny, n = len(ex), len(ey), ex.shape[1]
    left = np.empty((nx * ny, 2 * n))
    for a in range(nx):
        for b in range(ny):
            row = left[a * ny + b]
            for i in range(n):
                row[i] = ey[b, i] * (along_x[a, i] + ex[a, i] * along_y[b, i])
                row[n + i] = ex[a, i] * ey[b, i] * along_z[i]
    return left
