r"""Contact by the wrist's force-torque sensor (thesis, section 4.5.3).

Eq. 4.8: contact where :math:`\|F - F_0\| > \Delta F`, with :math:`F_0` stored at the tare.
Here F is the measured force less the hand's weight and inertia, both low-passed alike, so
that it stays flat while the hand turns and speeds up.

Threshold: white noise of 0.02 N at 500 Hz leaves the 10 Hz low-pass with 0.0042 N, and F_0
is as noisy, so 0.1 N is 17 deviations away and the drift, not the noise, bounds it. A light
object slides at 0.17 N, which a ramp passes long after 0.1 N; the filter delays by 22 ms,
0.7 mm at 3 cm/s. Heavy objects push harder than that delay would allow, so that a jump of the
unfiltered force, far above its noise and what the arm's motion leaves of it, counts at once.
"""

import dataclasses as dc
import math
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.sensing.contact_point import (
    Readings,
    Skin,
    contact_normal,
    contact_point,
    expected_approach,
)
from vh_drake.sensing.hand_load import HandInertia, load_of
from vh_drake.sensing.low_pass import LowPass, filtered, settle
from vh_drake.types import Array, ContactSet


@dc.dataclass
class FtContactSettings:
    """Knobs of the contact estimation."""

    period_s: float = 0.002  # of the samples [s]
    cutoff_hz: float = 10.0  # of the low-pass [Hz]
    threshold_n: float = 0.10  # ΔF of eq. 4.8 [N]
    fast_threshold_n: float = 0.5  # ΔF while the hand moves fast [N]
    fast_speed_m_s: float = 0.08  # [m/s]
    # From the first sample over ΔF to the last that is needed: a joint that meets its limit jolts
    # the hand for 6 ms [s].
    hold_s: float = 0.008
    # So with the force before the low-pass, which moving arms leave below 0.3 N for as long [N, s].
    jump_n: float = 0.8
    jump_s: float = 0.004
    settle_s: float = 0.1  # for which place and normal are read on, while the hand pushes [s]
    force_std_n: float = 0.02  # of one sample, per axis [N]
    torque_std_nm: float = 0.0005  # [N m]
    prior_std_m: float = 0.02  # of the contact about the expected place [m]
    friction: float = 0.8  # the most by which a force may lean from the normal

    def samples(self, duration_s: float) -> int:
        """How many samples in a row span at least a duration from the first to the last."""
        return 1 + math.ceil(duration_s / self.period_s - 1e-9)


class FtSample(NamedTuple):
    """One reading of sensor and kinematics."""

    wrench_H: Array  # (6,) [N m; N], as in `hand_load`
    R_WH: Array  # (3, 3)
    p_WH: Array  # (3,) [m]
    velocity_W: Array  # (6,) of H [rad/s; m/s]
    acceleration_W: Array  # (6,) of H [rad/s^2; m/s^2], of the same instant as the wrench
    approach_W: Array  # (3,) direction of motion; zero where unknown
    tare: float  # a change latches F_0


@dc.dataclass(frozen=True, eq=False)
class FtState:
    """All that the estimation remembers."""

    approach_W: Array = dc.field(default_factory=lambda: np.zeros(3))  # the last known
    low_pass: Array = dc.field(default_factory=lambda: np.zeros((2, 6)))
    wrench_H: Array = dc.field(default_factory=lambda: np.zeros(6))  # filtered, from outside
    offset_H: Array = dc.field(default_factory=lambda: np.zeros(6))  # F_0
    force_W: Array = dc.field(default_factory=lambda: np.zeros(3))  # F - F_0 [N]
    tare: float = 0.0  # the last request; nothing touches before the first change
    started: bool = False
    exceeded: int = 0  # samples in a row above ΔF; once touched, all samples since then
    jumped: int = 0  # samples in a row whose unfiltered force is above the jump
    readings: Readings = dc.field(default_factory=Readings)  # of the contact that is under way
    contact: ContactSet = dc.field(default_factory=ContactSet)  # since the last tare

    def to_vector(self) -> Array:
        """All of it as numbers (STATE_SIZE,), for a discrete state."""
        touched = len(self.contact) > 0
        place = (self.contact.p_WC[0], self.contact.n_WC[0]) if touched else (np.zeros(6),)
        counts = [float(self.exceeded), float(self.jumped)]
        flags = [self.tare, float(self.started), *counts, float(touched)]
        parts = (
            self.approach_W,
            self.low_pass.ravel(),
            self.wrench_H,
            self.offset_H,
            self.force_W,
        )
        read = self.readings
        sums = (read.force, read.forces.ravel(), read.moment, [read.torque])
        vector: Array = np.concatenate([*parts, flags, *sums, *place])
        return vector

    @staticmethod
    def from_vector(vector: Array) -> "FtState":
        """The inverse of `to_vector`."""
        approach, low_pass, wrench, offset, force, flags, sums, place = (
            vector[part] for part in _STATE_PARTS
        )
        touched = has_contact(vector)
        return FtState(
            approach_W=approach,
            low_pass=low_pass.reshape(2, 6),
            wrench_H=wrench,
            offset_H=offset,
            force_W=force,
            tare=float(flags[0]),
            started=bool(flags[1] > 0),
            exceeded=int(flags[2]),
            jumped=int(flags[3]),
            readings=Readings(sums[:3], sums[3:12].reshape(3, 3), sums[12:15], float(sums[15])),
            contact=ContactSet(place[None, :3], place[None, 3:]) if touched else ContactSet(),
        )


# Approach, low-pass, wrench, offset, force, flags, sums of readings, place.
_STATE_SIZES = (3, 12, 6, 6, 3, 5, 16, 6)
STATE_SIZE = sum(_STATE_SIZES)
_ENDS = tuple(accumulate(_STATE_SIZES))
_STATE_PARTS = tuple(slice(end - size, end) for size, end in zip(_STATE_SIZES, _ENDS, strict=True))
_APPROACH_END, _MEMORY_END, _WRENCH_END, _OFFSET_END, _FORCE_END, _FLAGS_END = _ENDS[:6]
_TARE, _STARTED, _EXCEEDED, _JUMPED, _TOUCHED = range(_FORCE_END, _FLAGS_END)


def has_contact(state: Array) -> bool:
    """Whether a state (STATE_SIZE,) has felt a contact since the last tare."""
    return bool(state[_TOUCHED] > 0)


def force_of(state: Array) -> Array:
    """F - F_0 (3,) [N] of a state (STATE_SIZE,), in W."""
    return state[_STATE_PARTS[4]]


class _Knobs(NamedTuple):
    """What a step needs of settings, filter and hand, as numbers."""

    thresholds_n: tuple[float, float]  # of the slow hand and the fast one
    fast_m_s: float
    jump_n: float
    jump_samples: int
    hold_samples: int
    settled: int  # samples above the threshold after which nothing is read any more
    b: tuple[float, float, float]
    a: tuple[float, float]
    mass: float


class FtContactModel:
    """The parts of the estimation that do not change.

    Args:
        skin: where the hand may touch.
        inertia: mass properties of the hand.
        settings: the knobs.

    Raises:
        BadInput: the low-pass does not fit the sampling period.
    """

    def __init__(
        self,
        skin: Skin,
        inertia: HandInertia | None = None,
        settings: FtContactSettings | None = None,
    ) -> None:
        self.skin = skin
        self.inertia = inertia or HandInertia()
        self.settings = settings or FtContactSettings()
        low_pass = LowPass.butterworth(self.settings.cutoff_hz, self.settings.period_s)
        gain = np.sqrt(2.0) * low_pass.noise_gain()  # F and F_0 are noisy alike.
        self.force_std_n = gain * self.settings.force_std_n
        self.torque_std_nm = gain * self.settings.torque_std_nm
        self._knobs = _knobs(self.settings, low_pass, self.inertia.mass)

    def step(self, state: FtState, sample: FtSample) -> FtState:
        """The state after one more sample; ignores a sample that is not finite."""
        before = state.to_vector()
        after = self.advance(before, sample)
        return state if after is before else FtState.from_vector(after)

    def advance(self, state: Array, sample: FtSample) -> Array:
        """`step` of states as numbers (STATE_SIZE,)."""
        after: Array = state.copy()
        touches = _advance(
            after,
            np.ascontiguousarray(sample.wrench_H, dtype=float),
            np.ascontiguousarray(sample.R_WH, dtype=float),
            np.ascontiguousarray(sample.p_WH, dtype=float),
            np.ascontiguousarray(sample.velocity_W, dtype=float),
            np.ascontiguousarray(sample.acceleration_W, dtype=float),
            np.ascontiguousarray(sample.approach_W, dtype=float),
            sample.tare,
            self.inertia.p_HCom,
            self.inertia.I_H,
            self._knobs,
        )
        if touches == _NOT_FINITE:
            return state
        if touches == _READS:
            return self._read(FtState.from_vector(after), sample).to_vector()
        return after

    def _read(self, state: FtState, sample: FtSample) -> FtState:
        """Takes a reading of the contact; place and normal follow from all of them."""
        earlier = state.readings if state.exceeded > 1 else Readings()
        readings = earlier.with_wrench(state.wrench_H - state.offset_H)
        state = dc.replace(state, readings=readings)
        if state.exceeded < self._knobs.hold_samples:
            return state
        return dc.replace(state, contact=self._contact(state, sample))

    def _contact(self, state: FtState, sample: FtSample) -> ContactSet:
        settings, R_WH = self.settings, sample.R_WH
        p_H, n_HSkin = contact_point(
            self.skin,
            state.readings,
            force_std_n=self.force_std_n,
            torque_std_nm=self.torque_std_nm,
            independent=settings.cutoff_hz * settings.period_s,
            prior_std_m=settings.prior_std_m,
            approach_H=R_WH.T @ state.approach_W,
        )
        expected_W = expected_approach(state.approach_W, R_WH @ n_HSkin)
        n_W = contact_normal(R_WH @ state.readings.force, expected_W, settings.friction)
        return ContactSet((sample.p_WH + R_WH @ p_H)[None], n_W[None])


def _knobs(settings: FtContactSettings, low_pass: LowPass, mass: float) -> _Knobs:
    hold = settings.samples(settings.hold_s)
    return _Knobs(
        thresholds_n=(float(settings.threshold_n), float(settings.fast_threshold_n)),
        fast_m_s=float(settings.fast_speed_m_s),
        jump_n=float(settings.jump_n),
        jump_samples=settings.samples(settings.jump_s),
        hold_samples=hold,
        settled=hold + settings.samples(settings.settle_s),
        b=low_pass.b,
        a=low_pass.a,
        mass=float(mass),
    )


_NOT_FINITE, _QUIET, _READS = range(3)


@njit(cache=True)
def _advance(
    state: Array,
    wrench_H: Array,
    R_WH: Array,
    p_WH: Array,
    velocity_W: Array,
    acceleration_W: Array,
    approach_W: Array,
    tare: float,
    p_HCom: Array,
    I_H: Array,
    knobs: _Knobs,
) -> int:
    """State (STATE_SIZE,) after a sample, in place, but for what a contact's readings tell.

    Returns _READS where a reading is to be taken, _NOT_FINITE where nothing was changed.
    """
    size = _sum(wrench_H) + _sum(velocity_W) + _sum(acceleration_W) + _sum(R_WH.ravel())
    if not np.isfinite(size + _sum(p_WH) + _sum(approach_W) + tare * tare):
        return _NOT_FINITE
    load = load_of(
        knobs.mass, p_HCom, I_H, R_WH, velocity_W[:3], acceleration_W[:3], acceleration_W[3:]
    )
    outside = wrench_H - load
    _filter(state, outside, knobs)
    wrench, offset = state[_MEMORY_END:_WRENCH_END], state[_WRENCH_END:_OFFSET_END]
    known = _sum(approach_W) > 0.0  # It ends with the motion.
    if known or tare != state[_TARE]:
        state[:_APPROACH_END] = approach_W
    if tare != state[_TARE]:
        offset[:] = wrench
        state[_OFFSET_END:] = 0.0
        state[_TARE], state[_STARTED] = tare, 1.0
        return _QUIET
    if tare == 0.0:
        return _QUIET
    state[_OFFSET_END:_FORCE_END] = R_WH @ (wrench - offset)[3:]
    jump = np.sqrt(_sum((outside - offset)[3:])) > knobs.jump_n
    state[_JUMPED] = state[_JUMPED] + 1.0 if jump else 0.0
    # Eq. 4.8, with a higher threshold while the hand moves fast.
    fast = np.sqrt(_sum(velocity_W[3:])) > knobs.fast_m_s
    threshold = knobs.thresholds_n[1] if fast else knobs.thresholds_n[0]
    touches = jump or np.sqrt(_sum(state[_OFFSET_END:_FORCE_END])) > threshold
    state[_EXCEEDED] = _count(state, touches, knobs)
    return _READS if touches and state[_EXCEEDED] <= knobs.settled else _QUIET


@njit(cache=True)
def _filter(state: Array, outside: Array, knobs: _Knobs) -> None:
    """Low-passes the wrench from outside (6,)."""
    memory = state[_APPROACH_END:_MEMORY_END].reshape(2, 6)
    if state[_STARTED] == 0.0:
        settle(knobs.b, knobs.a, outside, memory)
    state[_MEMORY_END:_WRENCH_END] = filtered(knobs.b, knobs.a, outside, memory)
    state[_STARTED] = 1.0


@njit(cache=True)
def _count(state: Array, touches: bool, knobs: _Knobs) -> float:
    """Samples in a row above the threshold or the jump, and after the touch all that follow."""
    if state[_TOUCHED] > 0.0:
        return min(state[_EXCEEDED], knobs.settled) + 1.0
    if state[_JUMPED] >= knobs.jump_samples:
        return max(state[_EXCEEDED] + 1.0, knobs.hold_samples)
    return state[_EXCEEDED] + 1.0 if touches else 0.0


@njit(cache=True)
def _sum(x: Array) -> float:
    """Of squares."""
    total = 0.0
    for value in x:
        total += value * value
    return total
