"""What a Gaussian process implicit surface is fitted to."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from vh_drake.errors import BadInput
from vh_drake.types import Array, IntArray


@dataclass(frozen=True, eq=False)
class Observations:
    """Values and, where their variance is finite, gradients of the potential at points.

    A camera point or contact has value 0 and its outward normal as gradient (eq. 3.17, 3.18, f
    negative inside). A point known to be outside has a positive value and no gradient:
    its gradient variance is infinite.
    """

    p: Array = field(default_factory=lambda: np.zeros((0, 3)))  # (n, 3) [m]
    value: Array = field(default_factory=lambda: np.zeros(0))  # (n,) [m]
    value_variance: Array = field(default_factory=lambda: np.zeros(0))  # (n,) [m²]
    gradient: Array = field(default_factory=lambda: np.zeros((0, 3)))  # (n, 3)
    gradient_variance: Array = field(default_factory=lambda: np.zeros(0))  # (n,)

    def __len__(self) -> int:
        return len(self.p)

    @cached_property
    def has_gradient(self) -> NDArray[np.bool_]:
        """(n,) whether the gradient was observed."""
        finite: NDArray[np.bool_] = np.isfinite(self.gradient_variance)
        return finite

    @cached_property
    def is_row(self) -> NDArray[np.bool_]:
        """(n, 4) which of value and gradient were observed: the rows of eq. 3.32."""
        return np.column_stack([np.ones(len(self), bool), *[self.has_gradient] * 3])

    @cached_property
    def row_starts(self) -> IntArray:
        """(n + 1,) the first row of each point in the extended vectors (eq. 3.35)."""
        starts = np.zeros(len(self) + 1, np.int64)
        np.cumsum(np.where(self.has_gradient, 4, 1), out=starts[1:])
        return starts

    def joined(self, other: "Observations") -> "Observations":
        """These observations followed by others."""
        return Observations(
            np.vstack([self.p, other.p]),
            np.concatenate([self.value, other.value]),
            np.concatenate([self.value_variance, other.value_variance]),
            np.vstack([self.gradient, other.gradient]),
            np.concatenate([self.gradient_variance, other.gradient_variance]),
        )

    def stacked(self, value: Array, gradient: Array) -> Array:
        """Interleave (n,) values and (n, 3) gradients to the rows of eq. 3.32."""
        rows = np.empty((len(self), 4))
        rows[:, 0], rows[:, 1:] = value, gradient
        stacked: Array = rows[self.is_row]
        return stacked


def surface_observations(
    p: Array, n: Array, *, value_std_m: float, gradient_std: float
) -> Observations:
    """Points on the surface with outward unit normals, all with the same noise."""
    size = len(p)
    return Observations(
        np.asarray(p, float).reshape(-1, 3),
        np.zeros(size),
        np.full(size, value_std_m**2),
        np.asarray(n, float).reshape(-1, 3),
        np.full(size, gradient_std**2),
    )


def value_observations(p: Array, value: Array, *, value_std_m: float) -> Observations:
    """Points (n, 3) at which only the potential (n,) is known, such as points outside."""
    size = len(p)
    return Observations(
        np.asarray(p, float).reshape(-1, 3),
        np.asarray(value, float),
        np.full(size, value_std_m**2),
        np.zeros((size, 3)),
        np.full(size, np.inf),
    )


def require_usable(observations: Observations) -> None:
    """Check what comes from outside.

    Raises:
        BadInput: nothing was observed, or something observed is not finite.
    """
    if len(observations) == 0:
        raise BadInput("no observation to estimate a surface from; give points or contacts")
    seen = observations.has_gradient
    parts = (observations.p, observations.value, observations.value_variance)
    if not all(np.isfinite(part).all() for part in (*parts, observations.gradient[seen])):
        raise BadInput("observations hold NaN or infinite numbers; drop these points")
    if (observations.value_variance < 0).any() or (observations.gradient_variance < 0).any():
        raise BadInput("a noise variance is negative; give variances of zero or more")
