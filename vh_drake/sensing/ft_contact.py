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

import numpy as np

from vh_drake.sensing.contact_point import (
    Readings,
    Skin,
    contact_normal,
    contact_point,
    expected_approach,
)
from vh_drake.sensing.hand_load import HandInertia, HandMotion, own_load
from vh_drake.sensing.low_pass import LowPass
from vh_drake.types import Array, ContactSet


@dc.dataclass
class FtContactSettings:
    """Knobs of the contact estimation."""

    period_s: float = 0.002  # of the samples [s]
    cutoff_hz: float = 10.0  # of the low-pass [Hz]
    threshold_n: float = 0.10  # ΔF of eq. 4.8 [N]
    fast_threshold_n: float = 0.5  # ΔF while the hand moves fast [N]
    fast_speed_m_s: float = 0.08  # [m/s]
    # ΔF must be exceeded for so long: a joint that meets its limit jolts the hand for 6 ms.
    hold_samples: int = 5
    # So does the force before the low-pass, which moving arms leave below 0.3 N for as long [N].
    jump_n: float = 0.8
    jump_samples: int = 3
    # Place and normal are read anew for so long after that, while the hand pushes the object.
    settle_samples: int = 50
    force_std_n: float = 0.02  # of one sample, per axis [N]
    torque_std_nm: float = 0.0005  # [N m]
    prior_std_m: float = 0.02  # of the contact about the expected place [m]
    friction: float = 0.8  # the most by which a force may lean from the normal


@dc.dataclass(frozen=True, eq=False)
class FtSample:
    """One reading of sensor and kinematics."""

    wrench_H: Array  # (6,) [N m; N], as in `hand_load`
    R_WH: Array  # (3, 3)
    p_WH: Array  # (3,) [m]
    velocity_W: Array  # (6,) of H [rad/s; m/s]
    approach_W: Array  # (3,) direction of motion; zero where unknown
    tare: float  # a change latches F_0


@dc.dataclass(frozen=True, eq=False)
class FtState:
    """All that the estimation remembers."""

    velocity_W: Array = dc.field(default_factory=lambda: np.zeros(6))  # last sample's
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
        motion = (self.velocity_W, self.approach_W)
        parts = (*motion, self.low_pass.ravel(), self.wrench_H, self.offset_H, self.force_W)
        read = self.readings
        sums = (read.force, read.forces.ravel(), read.moment, [read.torque])
        vector: Array = np.concatenate([*parts, flags, *sums, *place])
        return vector

    @staticmethod
    def from_vector(vector: Array) -> "FtState":
        """The inverse of `to_vector`."""
        motion, low_pass, wrench, offset, force, flags, sums, place = (
            vector[part] for part in _STATE_PARTS
        )
        touched = flags[4] > 0
        return FtState(
            velocity_W=motion[:6],
            approach_W=motion[6:],
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


# Motion, low-pass, wrench, offset, force, flags, sums of readings, place.
_STATE_SIZES = (9, 12, 6, 6, 3, 5, 16, 6)
STATE_SIZE = sum(_STATE_SIZES)
_STATE_PARTS = tuple(
    slice(end - size, end) for size, end in zip(_STATE_SIZES, accumulate(_STATE_SIZES), strict=True)
)


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
        self._settled = self.settings.hold_samples + self.settings.settle_samples
        self._filter = LowPass.butterworth(self.settings.cutoff_hz, self.settings.period_s)
        gain = np.sqrt(2.0) * self._filter.noise_gain()  # F and F_0 are noisy alike.
        self.force_std_n = gain * self.settings.force_std_n
        self.torque_std_nm = gain * self.settings.torque_std_nm

    def step(self, state: FtState, sample: FtSample) -> FtState:
        """The state after one more sample; ignores a sample that is not finite."""
        if not _finite(sample):
            return state
        state, outside = self._filtered(state, sample)
        if sample.tare != state.tare:
            return dc.replace(
                state,
                offset_H=state.wrench_H,
                force_W=np.zeros(3),
                approach_W=sample.approach_W.copy(),
                tare=sample.tare,
                exceeded=0,
                jumped=0,
                readings=Readings(),
                contact=ContactSet(),
            )
        if state.tare == 0.0:
            return state
        difference = state.wrench_H - state.offset_H
        jump = float(np.linalg.norm((outside - state.offset_H)[3:])) > self.settings.jump_n
        state = dc.replace(
            state,
            force_W=sample.R_WH @ difference[3:],
            jumped=state.jumped + 1 if jump else 0,
        )
        touches = jump or self._touches(state.force_W, sample)
        state = dc.replace(state, exceeded=self._count(state, touches))
        return self._read(state, sample, difference) if touches else state

    def _count(self, state: FtState, touches: bool) -> int:
        """Samples in a row above ΔF or the jump, and after the touch all that follow."""
        if len(state.contact):
            return min(state.exceeded, self._settled) + 1
        if state.jumped >= self.settings.jump_samples:
            return max(state.exceeded + 1, self.settings.hold_samples)
        return state.exceeded + 1 if touches else 0

    def _read(self, state: FtState, sample: FtSample, difference_H: Array) -> FtState:
        """Takes a reading of the contact; place and normal follow from all of them."""
        if state.exceeded > self._settled:
            return state
        earlier = state.readings if state.exceeded > 1 else Readings()
        state = dc.replace(state, readings=earlier.with_wrench(difference_H))
        if state.exceeded < self.settings.hold_samples:
            return state
        return dc.replace(state, contact=self._contact(state, sample))

    def _filtered(self, state: FtState, sample: FtSample) -> tuple[FtState, Array]:
        """Takes the hand's own load off and low-passes the rest (6,), which comes along."""
        before = state.velocity_W if state.started else sample.velocity_W
        rate = (sample.velocity_W - before) / self.settings.period_s
        motion = HandMotion(sample.R_WH, sample.velocity_W[:3], rate[:3], rate[3:])
        outside = sample.wrench_H - own_load(self.inertia, motion)
        memory = state.low_pass if state.started else self._filter.settled(outside)
        memory, wrench_H = self._filter.step(memory, outside)
        known = np.linalg.norm(sample.approach_W) > 0  # It ends with the motion.
        filtered = dc.replace(
            state,
            velocity_W=sample.velocity_W.copy(),
            approach_W=sample.approach_W.copy() if known else state.approach_W,
            low_pass=memory,
            wrench_H=wrench_H,
            started=True,
        )
        return filtered, outside

    def _touches(self, force_W: Array, sample: FtSample) -> bool:
        """Eq. 4.8, with a higher ΔF while the hand moves fast."""
        fast = float(np.linalg.norm(sample.velocity_W[3:])) > self.settings.fast_speed_m_s
        threshold = self.settings.fast_threshold_n if fast else self.settings.threshold_n
        return float(np.linalg.norm(force_W)) > threshold

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


def _finite(sample: FtSample) -> bool:
    vectors = (sample.wrench_H, sample.velocity_W, sample.p_WH, sample.approach_W)
    # A sum of squares is finite only where all numbers are.
    squares = sum(float(v @ v) for v in (*vectors, sample.R_WH.ravel()))
    return math.isfinite(squares + sample.tare)
