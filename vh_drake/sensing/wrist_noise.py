"""What a wrist force-torque sensor adds to the true wrench.

The defaults describe the class of the ATI Mini40 (calibration SI-80-4: resolution 0.02 N in
force and 0.0005 N m in torque at 16 bit), taken as the standard deviation of one sample at
500 Hz; and a slow drift as temperature causes it, which taring removes but for its change.
"""

import dataclasses as dc
import functools

import numpy as np
from numba import njit

from vh_drake.types import Array

_PERIODS_S = np.array([23.0, 41.0, 67.0])  # of the sinusoids that make up the drift


@dc.dataclass
class WristNoiseSettings:
    """Knobs of the sensor's noise."""

    force_std_n: float = 0.02  # white noise of one sample, per axis [N]
    torque_std_nm: float = 0.0005  # [N m]
    force_drift_n: float = 0.01  # amplitude of the drift, per axis [N]
    torque_drift_nm: float = 0.0002  # [N m]


def wrist_noise(time_s: float, seed: int, settings: WristNoiseSettings | None = None) -> Array:
    """Noise (6,) [N m; N] at an instant: a function of time and seed without memory.

    White noise is drawn anew every microsecond; the drift is a sum of three sinusoids with
    periods of 23 to 67 s whose phases the seed draws.
    """
    s = settings or WristNoiseSettings()
    white, slow = (s.torque_std_nm, s.force_std_n), (s.torque_drift_nm, s.force_drift_n)
    noise: Array = _noise(time_s, seed, _phases(seed), white, slow)
    return noise


@njit(cache=True)
def _noise(
    time_s: float,
    seed: int,
    phases: Array,
    white: tuple[float, float],
    slow: tuple[float, float],
) -> Array:
    """Noise (6,); deviations of the white noise and amplitudes of the drift: torque, force."""
    noise = _normals(seed, max(0, round(time_s * 1e6)) + 1)
    for i in range(6):
        drift = 0.0
        for k in range(len(_PERIODS_S)):
            drift += np.sin(2.0 * np.pi * time_s / _PERIODS_S[k] + phases[i, k])
        noise[i] = white[i // 3] * noise[i] + slow[i // 3] * drift / len(_PERIODS_S)
    return noise


@njit(cache=True)
def _normals(seed: int, tick: int) -> Array:
    """Six normal numbers by Box and Muller from hashes of seed, tick and place."""
    result = np.empty(6)
    state = _mixed(np.uint64(seed) * np.uint64(0xD1342543DE82EF95) + np.uint64(tick))
    for i in range(0, 6, 2):
        state = _mixed(state)
        u = (np.float64(state >> np.uint64(11)) + 0.5) * 2.0**-53
        state = _mixed(state)
        v = (np.float64(state >> np.uint64(11)) + 0.5) * 2.0**-53
        radius = np.sqrt(-2.0 * np.log(u))
        result[i] = radius * np.cos(2.0 * np.pi * v)
        result[i + 1] = radius * np.sin(2.0 * np.pi * v)
    return result


@njit(cache=True)
def _mixed(x: np.uint64) -> np.uint64:
    """The next number of SplitMix64 (Steele et al. 2014)."""
    x = x + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@functools.lru_cache(maxsize=16)
def _phases(seed: int) -> Array:
    """Phases (6, 3) [rad] of the drift."""
    return np.random.default_rng([seed, 0]).uniform(0.0, 2.0 * np.pi, (6, 3))
