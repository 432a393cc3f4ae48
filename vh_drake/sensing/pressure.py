"""A barometer cast in polyurethane as a touch sensor, and contact told from it (section 3.4).

A force on the pad compresses a bubble of air over the barometer (BMP280). What it reads is

    sensitivity times force, less what the polyurethane has crept, plus drift, plus noise.

The bubble is sealed, so its pressure follows the temperature: it drifts by far more than a touch
changes it. Contact is therefore told from the filtered pressure, from which a baseline that
follows the drift is subtracted as long as nothing is touched.
"""

import dataclasses as dc

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.sensing.low_pass import LowPass
from vh_drake.types import Array, Immutable


@dc.dataclass
class PressureSettings:
    """The element. The noise is the BMP280's (data sheet); the thesis gives none of the rest."""

    pa_per_n: float = 1000.0  # sensitivity
    noise_pa: float = 1.3  # standard deviation of a sample
    resolution_pa: float = 0.16
    warming_pa_s: float = 8.0  # largest steady drift; the seed draws its size and sign
    walk_pa: float = 5.0  # standard deviation of the random drift after one second
    creep_share: float = 0.05  # of the pressure that a lasting force loses
    creep_s: float = 3.0  # time constant of the creep


@dc.dataclass
class DetectionSettings:
    """How contact is told from the pressure."""

    filter_hz: float = 10.0
    baseline_s: float = 1.0  # time constant of the drift compensation
    threshold_pa: float = 150.0  # of the filtered pressure, where contact begins
    release_share: float = 0.5  # of the threshold, where it ends


@dc.dataclass(frozen=True)
class PressureState(Immutable):
    """What the element remembers [Pa]."""

    warming_pa_s: float
    drift_pa: float = 0.0
    creep_pa: float = 0.0
    reading_pa: float = 0.0  # over the ambient pressure at the start


@dc.dataclass(frozen=True, eq=False)
class DetectionState(Immutable):
    """What the detection remembers."""

    low_pass: Array  # (2, 1)
    baseline_pa: float
    filtered_pa: float = 0.0  # less the baseline
    contact: bool = False


def start_pressure(settings: PressureSettings, rng: np.random.Generator) -> PressureState:
    """An element that nothing touches; draws how it warms.

    Raises:
        BadInput: a setting is negative, or a time constant is not positive.
    """
    values = dc.asdict(settings)
    if not all(np.isfinite(v) and v >= 0.0 for v in values.values()):
        raise BadInput(f"settings of a pressure element can't be negative: {settings}")
    if not (settings.creep_s > 0.0 and settings.pa_per_n > 0.0):
        raise BadInput(f"pa_per_n and creep_s must be positive: {settings}")
    return PressureState(settings.warming_pa_s * float(rng.uniform(-1.0, 1.0)))


def step_pressure(
    state: PressureState,
    force_n: float,
    period_s: float,
    settings: PressureSettings,
    rng: np.random.Generator,
) -> PressureState:
    """The next sample under a force normal to the pad; pulling counts as none."""
    loaded = settings.pa_per_n * max(force_n, 0.0)
    decay = 1.0 - np.exp(-period_s / settings.creep_s)
    creep = state.creep_pa + decay * (settings.creep_share * loaded - state.creep_pa)
    walk, noise = rng.standard_normal(2)
    drift = state.drift_pa + state.warming_pa_s * period_s
    drift += settings.walk_pa * np.sqrt(period_s) * walk
    reading = loaded - creep + drift + settings.noise_pa * noise
    if settings.resolution_pa > 0.0:
        reading = settings.resolution_pa * np.round(reading / settings.resolution_pa)
    return PressureState(state.warming_pa_s, float(drift), float(creep), float(reading))


def detection_filter(settings: DetectionSettings, period_s: float) -> LowPass:
    """The filter of the pressure.

    Raises:
        BadInput: a setting is out of range.
    """
    if not (settings.threshold_pa > 0.0 and settings.baseline_s > 0.0):
        raise BadInput(f"threshold_pa and baseline_s must be positive: {settings}")
    if not 0.0 < settings.release_share <= 1.0:
        raise BadInput(f"release_share is {settings.release_share:g}; choose a share up to 1")
    return LowPass.butterworth(settings.filter_hz, period_s)


def start_detection(reading_pa: float, low_pass: LowPass) -> DetectionState:
    """Detection that begins where nothing is touched."""
    return DetectionState(low_pass.settled(np.array([reading_pa])), reading_pa)


def step_detection(
    state: DetectionState,
    reading_pa: float,
    period_s: float,
    settings: DetectionSettings,
    low_pass: LowPass,
) -> DetectionState:
    """Contact after one more sample; the baseline rests while there is contact."""
    memory, (smooth,) = low_pass.step(state.low_pass, np.array([reading_pa]))
    limit = settings.threshold_pa * (settings.release_share if state.contact else 1.0)
    filtered = float(smooth) - state.baseline_pa
    contact = filtered > limit
    baseline = state.baseline_pa
    if not contact:
        baseline += (1.0 - np.exp(-period_s / settings.baseline_s)) * filtered
    return DetectionState(memory, float(baseline), filtered, contact)
