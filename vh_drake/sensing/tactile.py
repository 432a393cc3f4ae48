"""The tactile normal sensor: contact from pressure, the surface's normal from orientation.

The sensor hangs on a coil spring and lays itself flat on what it is pressed against. Once the
pressure says that the force is large enough for that, the orientation of the unit inside is that
of the surface (section 3.4).
"""

import dataclasses as dc

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.sensing.imu import ImuSettings, measured_rotation, start_drift, step_drift
from vh_drake.sensing.low_pass import LowPass
from vh_drake.sensing.pressure import (
    DetectionSettings,
    DetectionState,
    PressureSettings,
    PressureState,
    detection_filter,
    start_detection,
    start_pressure,
    step_detection,
    step_pressure,
)
from vh_drake.types import Array, Immutable

PERIOD_S = 0.01  # The orientation is fused at 100 Hz.
N_SPAD = np.array([0.0, 0.0, -1.0])  # outward normal of the pad in the sensor's frame S


@dc.dataclass
class TactileSettings:
    """Knobs of the sensor."""

    pressure: PressureSettings = dc.field(default_factory=PressureSettings)
    detection: DetectionSettings = dc.field(default_factory=DetectionSettings)
    imu: ImuSettings = dc.field(default_factory=ImuSettings)
    aligned_n: float = 1.4  # estimated force at which the pad lies flat


@dc.dataclass(frozen=True, eq=False)
class TactileState(Immutable):
    """What the sensor remembers and says."""

    element: PressureState
    detection: DetectionState
    drift: Array  # (3,) of the orientation [rad]
    R_WS: Array  # (3, 3) measured orientation
    normal_W: Array  # (3,) outward normal of the last surface felt; zero before the first
    aligned: bool = False  # whether the normal was read in the present contact


class TactileSensor:
    """Steps of the sensor at a fixed period.

    Args:
        settings: of pressure, detection and orientation.

    Raises:
        BadInput: a setting is out of range.
    """

    def __init__(self, settings: TactileSettings | None = None) -> None:
        self.settings = settings or TactileSettings()
        self._low_pass: LowPass = detection_filter(self.settings.detection, PERIOD_S)
        aligned_pa = self.settings.aligned_n * self.settings.pressure.pa_per_n
        if not aligned_pa >= self.settings.detection.threshold_pa:
            raise BadInput(
                f"aligned_n {self.settings.aligned_n:g} N gives {aligned_pa:g} Pa, less than the "
                f"contact threshold of {self.settings.detection.threshold_pa:g} Pa; raise it"
            )
        self._aligned_pa = aligned_pa

    def start(self, R_WS: Array, rng: np.random.Generator) -> TactileState:
        """The sensor at rest, touching nothing, its drifts drawn."""
        element = start_pressure(self.settings.pressure, rng)
        drift = start_drift(self.settings.imu, rng)
        return TactileState(element, start_detection(0.0, self._low_pass), drift, R_WS, np.zeros(3))

    def step(
        self, state: TactileState, force_n: float, R_WS: Array, rng: np.random.Generator
    ) -> TactileState:
        """The sensor a period later.

        Args:
            state: before.
            force_n: normal to the pad, pushing positive.
            R_WS: true orientation (3, 3).
            rng: of the noise.
        """
        settings = self.settings
        element = step_pressure(state.element, force_n, PERIOD_S, settings.pressure, rng)
        detection = step_detection(
            state.detection, element.reading_pa, PERIOD_S, settings.detection, self._low_pass
        )
        drift = step_drift(state.drift, PERIOD_S, settings.imu, rng)
        measured = measured_rotation(R_WS, drift, settings.imu, rng)
        aligned = detection.contact and state.aligned
        normal = state.normal_W
        if detection.contact and not aligned and detection.filtered_pa >= self._aligned_pa:
            aligned, normal = True, -measured @ N_SPAD
        return TactileState(element, detection, drift, measured, normal, aligned)
