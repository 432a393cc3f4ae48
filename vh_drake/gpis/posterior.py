r"""Posterior of a Gaussian process on values and gradients (section 3.2.2).

.. math:: f^*(x) = k^{+*\top} w^+, \quad w^+ = (K^+ + \Sigma)^{-1} y^+

.. math:: Q(x) = k(x, x) - k^{+*\top} (K^+ + \Sigma)^{-1} k^{+*}

(eq. 3.34, 3.36 as corrected, 3.57), with Σ the diagonal of the noise variances, one for each
observed value and gradient. Lengths are scaled by 0.1 m inside, so that values and gradients are
of one magnitude; arguments and results are in metres.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky
from scipy.linalg.blas import dtrsm

from vh_drake.errors import IllConditionedKernel
from vh_drake.gpis.growing_factor import GrowingFactor
from vh_drake.gpis.kernels import (
    SQUARED_EXPONENTIAL,
    Kernel,
    covariance_matrix,
    plane_factors,
    weighted_sum,
)
from vh_drake.gpis.observations import Observations, require_usable
from vh_drake.types import Array, IntArray

SCALE_M = 0.1
JITTER = 1e-9  # of the signal's variance: keeps exact duplicates solvable


@dataclass(frozen=True, eq=False)
class Posterior:
    """A fitted Gaussian process; `append` gives a new one."""

    kernel: Kernel
    observations: Observations
    factor: GrowingFactor  # of K⁺ + Σ, scaled
    weights: Array  # (n, 4) of values and gradients, zero where no gradient was seen, scaled

    def mean(self, p: Array) -> Array:
        """Potential f (m,) at points (m, 3) [m]; negative inside."""
        return self.mean_and_gradient(p)[0]

    def gradient(self, p: Array) -> Array:
        """∇f (m, 3) at points (m, 3)."""
        return self.mean_and_gradient(p)[1]

    def mean_and_gradient(self, p: Array) -> tuple[Array, Array]:
        """Potential (m,) and gradient (m, 3) at points (m, 3) [m], for the price of one."""
        points = np.ascontiguousarray(p / SCALE_M)
        both = weighted_sum(*scaled(self.kernel), points, self.columns)
        return SCALE_M * both[:, 0], both[:, 1:]

    @cached_property
    def columns(self) -> Array:
        """(7, n) coordinates and weights of the observed points, scaled."""
        return np.ascontiguousarray(np.column_stack([self._centres, self.weights]).T)

    def variance(self, p: Array) -> Array:
        """Posterior variance of f (m,) at points (m, 3) [m²] (eq. 3.57)."""
        points = np.ascontiguousarray(p / SCALE_M)
        cross = _covariance(
            self.kernel, self._centres, self.observations.row_starts, points, _values(points)
        )
        half = _solve_lower(self.factor.lower, cross)
        prior = (self.kernel.signal_std_m / SCALE_M) ** 2
        variance: Array = SCALE_M**2 * np.maximum(prior - np.einsum("ij,ij->j", half, half), 0.0)
        return variance

    def mean_on_grid(self, x: Array, y: Array, z: Array) -> Array:
        """Potential on the grid of coordinates x, y and z [m], (nx, ny, nz).

        The squared exponential separates along the axes, which makes this one matrix product.
        """
        if self.kernel.code == SQUARED_EXPONENTIAL:
            return self._mean_on_separable_grid(x, y, z)
        nodes = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)
        return self.mean(nodes.reshape(-1, 3)).reshape(nodes.shape[:3])

    def append(self, observations: Observations) -> "Posterior":
        """The posterior with more observations, by a block update of the factor in O(rows²)."""
        require_usable(observations)
        old, new = self._centres, observations.p / SCALE_M
        side = _covariance(
            self.kernel, new, observations.row_starts, old, self.observations.row_starts
        )
        try:
            factor = self.factor.extended(side, _noisy_covariance(self.kernel, observations))
        except np.linalg.LinAlgError as error:
            raise _ill_conditioned(self.factor.rows + len(side), self.kernel) from error
        return _solved(self.kernel, self.observations.joined(observations), factor)

    @cached_property
    def _centres(self) -> Array:
        return self.observations.p / SCALE_M

    def _mean_on_separable_grid(self, x: Array, y: Array, z: Array) -> Array:
        length = self.kernel.length_m / SCALE_M
        signal2 = (self.kernel.signal_std_m / SCALE_M) ** 2
        centres = self._centres
        offsets = [np.subtract.outer(a / SCALE_M, centres[:, i]) for i, a in enumerate((x, y, z))]
        ex, ey, ez = (np.exp(-0.5 * (offset / length) ** 2) for offset in offsets)  # (nx, n), ...
        slopes = self.weights[:, 1:] / length**2
        along_x = ex * (self.weights[:, 0] + offsets[0] * slopes[:, 0])
        left = plane_factors(ex, ey, along_x, offsets[1] * slopes[:, 1], slopes[:, 2])
        right = np.concatenate([ez, ez * offsets[2]], axis=1)
        right *= SCALE_M * signal2
        potential: Array = left @ right.T
        return potential.reshape(len(x), len(y), len(z))


def fit(kernel: Kernel, observations: Observations) -> Posterior:
    """Condition a Gaussian process on observations.

    Raises:
        BadInput: nothing observed, or not finite.
        IllConditionedKernel: the covariance matrix is not positive definite.
    """
    require_usable(observations)
    K = _noisy_covariance(kernel, observations)
    try:
        lower = cholesky(K, lower=True, check_finite=False)
    except np.linalg.LinAlgError as error:
        raise _ill_conditioned(len(K), kernel) from error
    return _solved(kernel, observations, GrowingFactor.of(np.ascontiguousarray(lower)))


def _solved(kernel: Kernel, observations: Observations, factor: GrowingFactor) -> Posterior:
    y = observations.stacked(observations.value / SCALE_M, observations.gradient)
    solution = factor.solve(y)  # w⁺, eq. 3.34
    weights = np.zeros((len(observations), 4))
    weights[observations.is_row] = solution
    return Posterior(kernel, observations, factor, weights)


def _noisy_covariance(kernel: Kernel, observations: Observations) -> Array:
    points, starts = observations.p / SCALE_M, observations.row_starts
    K = _covariance(kernel, points, starts, points, starts)
    variance = observations.value_variance / SCALE_M**2
    jitter = JITTER * (kernel.signal_std_m / SCALE_M) ** 2
    noise = observations.stacked(variance, observations.gradient_variance[:, None])
    K.ravel()[:: len(K) + 1] += noise + jitter
    return K


def _covariance(kernel: Kernel, p: Array, start_p: IntArray, q: Array, start_q: IntArray) -> Array:
    K: Array = covariance_matrix(*scaled(kernel), p, start_p, q, start_q)
    return K


def scaled(kernel: Kernel) -> tuple[int, float, float]:
    """Code, length and variance of a kernel in the unit that is used inside."""
    return kernel.code, kernel.length_m / SCALE_M, (kernel.signal_std_m / SCALE_M) ** 2


def _values(points: Array) -> IntArray:
    return np.arange(len(points) + 1, dtype=np.int64)


def _solve_lower(factor: Array, cross: Array) -> Array:
    """L⁻¹ B in place of B; transposed, since BLAS keeps columns together."""
    transposed = dtrsm(
        1.0, np.asfortranarray(factor), cross.T, side=1, lower=1, trans_a=1, overwrite_b=1
    )
    half: Array = transposed.T
    return half


def _ill_conditioned(rows: int, kernel: Kernel) -> IllConditionedKernel:
    return IllConditionedKernel(
        f"kernel matrix of {rows} rows is not positive definite (length_m="
        f"{kernel.length_m:g}); raise the noise variances, drop duplicate points, shorten a "
        "squared exponential's length, or widen a thin plate's radius to 1.2 times the "
        "largest distance between points"
    )
