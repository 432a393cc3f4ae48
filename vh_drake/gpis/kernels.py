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


@numba.njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def weighted_potential(
    code: int,
    length: float,
    signal2: float,
    x: Array,
    p: Array,
    weights: Array,
) -> Array:
    """Potential at points x: eq. 3.36 with weights (n, 4), zero where no gradient was seen."""
    f = np.empty(len(x))
    for a in range(len(x)):
        total = 0.0
        for i in range(len(p)):
            rx, ry, rz = x[a, 0] - p[i, 0], x[a, 1] - p[i, 1], x[a, 2] - p[i, 2]
            d2 = rx * rx + ry * ry + rz * rz
            phi, g, _ = radial_profile(code, d2, length, signal2)
            slope = rx * weights[i, 1] + ry * weights[i, 2] + rz * weights[i, 3]
            total += weights[i, 0] * phi - g * slope
        f[a] = total
    return f


@numba.njit(cache=True)
def weighted_gradient(
    code: int,
    length: float,
    signal2: float,
    x: Array,
    p: Array,
    weights: Array,
) -> Array:
    """Gradient of eq. 3.36 at points x, (m, 3)."""
    gradient = np.zeros((len(x), 3))
    r = np.empty(3)
    for a in range(len(x)):
        for i in range(len(p)):
            for n in range(3):
                r[n] = x[a, n] - p[i, n]
            d2 = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
            _, g, h = radial_profile(code, d2, length, signal2)
            slope = r[0] * weights[i, 1] + r[1] * weights[i, 2] + r[2] * weights[i, 3]
            for n in range(3):
                gradient[a, n] += r[n] * (weights[i, 0] * g - h * slope) - g * weights[i, 1 + n]
    return gradient
