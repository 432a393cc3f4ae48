"""A second-order low-pass filter whose state is a value."""

import dataclasses as dc
import math

import numpy as np
from numba import njit

from vh_drake.errors import BadInput
from vh_drake.types import Array


@dc.dataclass(frozen=True)
class LowPass:
    """Coefficients of a Butterworth filter of second order, in transposed direct form II."""

    b: tuple[float, float, float]
    a: tuple[float, float]

    @classmethod
    def butterworth(cls, cutoff_hz: float, period_s: float) -> "LowPass":
        """The bilinear transform of 1 / (s^2 + sqrt(2) s + 1), warped to the cutoff.

        Raises:
            BadInput: the cutoff lies outside 0 ... half the sampling rate.
        """
        if period_s <= 0.0 or not 0.0 < cutoff_hz * period_s < 0.5:
            raise BadInput(
                f"a low-pass of {cutoff_hz:g} Hz needs a sampling period between 0 and "
                f"{0.5 / cutoff_hz if cutoff_hz > 0 else 0:g} s, not {period_s:g} s"
            )
        k = math.tan(math.pi * cutoff_hz * period_s)
        scale = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
        b = k * k * scale
        return cls(
            (b, 2.0 * b, b),
            (2.0 * (k * k - 1.0) * scale, (1.0 - math.sqrt(2.0) * k + k * k) * scale),
        )

    def settled(self, value: Array) -> Array:
        """State (2, n) of a filter that has seen `value` (n,) for ever."""
        state = np.empty((2, len(value)))
        settle(self.b, self.a, np.ascontiguousarray(value, dtype=float), state)
        return state

    def step(self, state: Array, value: Array) -> tuple[Array, Array]:
        """Next state (2, n) and output (n,) for an input (n,)."""
        after = np.array(state, dtype=float)
        out = filtered(self.b, self.a, np.ascontiguousarray(value, dtype=float), after)
        return after, out

    def noise_gain(self) -> float:
        """Standard deviation of the output for white noise of standard deviation 1."""
        state, total = np.zeros((2, 1)), 0.0
        for i in range(100_000):
            state, out = self.step(state, np.array([1.0 if i == 0 else 0.0]))
            total += float(out[0]) ** 2
            if i > 10 and float(np.abs(state).max()) < 1e-9:
                break
        return math.sqrt(total)


@njit(cache=True)
def settle(
    b: tuple[float, float, float], a: tuple[float, float], value: Array, state: Array
) -> None:
    """`LowPass.settled` in place, for compiled code."""
    state[0], state[1] = (b[1] - a[0] + b[2] - a[1]) * value, (b[2] - a[1]) * value


@njit(cache=True)
def filtered(
    b: tuple[float, float, float], a: tuple[float, float], value: Array, state: Array
) -> Array:
    """`LowPass.step` in place, for compiled code: the output."""
    out: Array = b[0] * value + state[0]
    state[0] = b[1] * value - a[0] * out + state[1]
    state[1] = b[2] * value - a[1] * out
    return out
