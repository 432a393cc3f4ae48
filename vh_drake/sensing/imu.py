r"""Orientation from a fusing inertial measurement unit (BNO055), with its noise and drift.

The unit reports an absolute orientation. It errs by a small rotation vector e in the world,

.. math:: \hat R = \exp([e + ν]_\times) R

where ν is white noise and e wanders slowly about zero: a first-order Gauss-Markov process, equal
about all axes, whose standard deviation and time constant are settings. The data sheet gives no
figure for the fused orientation; the drift is the one for which touches of tilted surfaces err
by 7.3 degrees on average, as in section 3.6.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.types import Array


@dc.dataclass
class ImuSettings:
    """Errors of the orientation."""

    noise_deg: float = 0.2  # standard deviation of a sample, per axis
    drift_deg: float = 5.5  # standard deviation of the drift, per axis
    drift_s: float = 60.0  # time after which a drift is forgotten


def start_drift(settings: ImuSettings, rng: np.random.Generator) -> Array:
    """A drift e (3,) [rad] of a unit that has run for long.

    Raises:
        BadInput: a setting is negative, or the time constant is not positive.
    """
    if not (settings.noise_deg >= 0.0 and settings.drift_deg >= 0.0 and settings.drift_s > 0.0):
        raise BadInput(f"noise and drift can't be negative, drift_s must be positive: {settings}")
    drift: Array = np.deg2rad(settings.drift_deg) * rng.standard_normal(3)
    return drift


def step_drift(
    drift: Array, period_s: float, settings: ImuSettings, rng: np.random.Generator
) -> Array:
    """The drift (3,) [rad] one period later; exact for any period."""
    kept = np.exp(-period_s / settings.drift_s)
    spread = np.deg2rad(settings.drift_deg) * np.sqrt(1.0 - kept * kept)
    later: Array = kept * drift + spread * rng.standard_normal(3)
    return later


def measured_rotation(
    R_WS: Array, drift: Array, settings: ImuSettings, rng: np.random.Generator
) -> Array:
    """What the unit says of the orientation (3, 3) of the sensor S in the world W."""
    noise = np.deg2rad(settings.noise_deg) * rng.standard_normal(3)
    rotation: Array = Rotation.from_rotvec(drift + noise).as_matrix() @ R_WS
    return rotation
