r"""The finger of section 4.5.4: joint angles for a given shortening of its tendon.

A tendon runs past n sprung joints. Without friction its tension F is the same at all of them
(eq. 4.10), and each joint balances tendon and spring (eq. 4.9 and 4.14) between its stops:

.. math:: R_i(θ_i) F = K_i (θ_i + θ_{0,i}), \quad 0 ≤ θ_i ≤ θ_{max,i}

The tendon is shortened by (eq. 4.13 and 4.15)

.. math:: ΔL = \sum_i \frac{2}{π} L_{0,i} θ_i

Two laws are offered for the lever. It grows with the angle (eq. 4.12, with the angle that its
end values 7.5 and 10.6 mm need),

.. math:: R_i(θ) = \sqrt{2} R_{0,i} \sin(π/4 + θ/2)

or it is constant, R_i = 2 L_{0,i} / π, which is the only one that agrees with the linear
shortening by virtual work, and the one of the simulated hand.

The force that holds joint i at θ, F_i(θ) = K_i (θ + θ_0) / R_i(θ), grows with θ where θ_0 < 2 rad:
its logarithmic slope 1 / (θ + θ_0) - cot(π/4 + θ/2) / 2 is then positive. So every joint moves
over an interval of forces of its own, and ΔL grows with F. Between the ends of these intervals
the same joints move, and n smooth equations are left, which Newton's method solves from an
interpolated start in one step or two.
"""

import dataclasses as dc
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numba import njit

from vh_drake.errors import BadInput
from vh_drake.types import Array

Lever = Literal["growing", "constant"]
LEVERS: tuple[Lever, ...] = ("growing", "constant")

_PRELOAD_LIMIT_RAD = 2.0  # Above it the force of the growing lever first falls with the angle.
_PIECES = 64  # of an interval of forces, for the start of Newton's method
_MOST_STEPS = 20
_LAST_STEP_RAD = 1e-8  # The error after a step is about its square.


class Knots(NamedTuple):
    """Equilibria between which the start is interpolated; m of them, m - 1 pieces."""

    shortening: Array  # (m,) ascending [m]
    angles: Array  # (m, n) [rad]
    first_slope: Array  # (m - 1, n) dθ/dΔL at a piece's start [rad/m]; 0 where a joint rests
    last_slope: Array  # (m - 1, n) at its end
    stop_n: float  # tension at which the last joint reaches its closed stop


@dc.dataclass(frozen=True, eq=False)
class Equilibrium:
    """Joints and tendon at rest, for one shortening or for many (...)."""

    angles: Array  # (..., n) [rad]
    tension_n: Array  # (...,) in the tendon; 0 where it is slack


@dc.dataclass(frozen=True, eq=False)
class TendonFinger:
    """A tendon and the joints that it closes; table 4.3 has the symbols.

    Attributes:
        stiffness: K_i of the torsion springs (n,) [N m/rad].
        preload: θ_{0,i}, their pretension at the open stops (n,) [rad].
        lever_open_m: R_{0,i} (n,); the constant lever does not need it.
        length_m: L_{0,i}, the shortening that turns a joint by 90 degrees (n,).
        upper: θ_{max,i}, the closed stops (n,) [rad].
        lever: the law of the lever.

    Raises:
        BadInput: a value is not positive and finite, or a pretension is 2 rad or more.
    """

    stiffness: Array
    preload: Array
    lever_open_m: Array
    length_m: Array
    upper: Array
    lever: Lever = "growing"

    def __post_init__(self) -> None:
        for name in ("stiffness", "preload", "lever_open_m", "length_m", "upper"):
            values = getattr(self, name)
            if not (np.isfinite(values).all() and np.all(values > 0)):
                raise BadInput(f"{name} of a finger's joints is {values}; all must be positive")
        if np.any(self.preload >= _PRELOAD_LIMIT_RAD) or np.any(self.upper > np.pi / 2):
            raise BadInput(
                f"preload {self.preload} and upper {self.upper} rad; the model holds for a "
                f"pretension below {_PRELOAD_LIMIT_RAD:g} rad and joints up to 90 degrees"
            )
        if self.lever not in LEVERS:
            raise BadInput(f"lever is {self.lever!r}; choose one of: {', '.join(LEVERS)}")

    @property
    def shortening_per_rad(self) -> Array:
        """(n,) dΔL/dθ_i of eq. 4.13 [m/rad]."""
        return 2.0 * self.length_m / np.pi

    @property
    def closed_m(self) -> float:
        """The shortening that closes all joints."""
        return float(self.shortening_per_rad @ self.upper)

    def levers(self, angles: Array) -> Array:
        """R_i (..., n) [m] at joint angles (..., n) [rad]."""
        if self.lever == "constant":
            return np.broadcast_to(self.shortening_per_rad, np.shape(angles))
        grown: Array = np.sqrt(2.0) * self.lever_open_m * np.sin(np.pi / 4 + angles / 2)
        return grown

    def holding_force(self, angles: Array) -> Array:
        """F_i (..., n) [N]: the tension that holds each joint at its angle."""
        force: Array = self.stiffness * (angles + self.preload) / self.levers(angles)
        return force

    def equilibrium(self, shortening_m: Array | float) -> Equilibrium:
        """Joints and tension where the tendon is shortened by (...) [m].

        A shortening of zero or less leaves the tendon slack: all joints rest at their open
        stops. Between the stops force and shortening are met to rounding.

        Raises:
            BadInput: a shortening is not finite, or more than the closed joints take.
        """
        wanted = np.asarray(shortening_m, np.float64)
        if not np.isfinite(wanted).all() or np.any(wanted > self.closed_m * (1.0 + 1e-12)):
            raise BadInput(
                f"a shortening of {np.max(wanted):g} m can't be; the joints are closed at "
                f"{self.closed_m:g} m"
            )
        angles = np.empty((wanted.size, len(self.upper)))
        tension = np.empty(wanted.size)
        law = (self.stiffness, self.preload, self._force_scale, self.shortening_per_rad)
        solve(np.ravel(wanted), self.knots, *law, self.lever == "growing", angles, tension)
        return Equilibrium(angles.reshape(*wanted.shape, -1), tension.reshape(wanted.shape))

    def torques(self, state: Equilibrium) -> Array:
        """Torques (..., n) of the tendon at the joints [N m] (eq. 4.9).

        At a joint between its stops it is that of the spring; at a stop, the stop or the spring
        takes the difference.
        """
        torques: Array = state.tension_n[..., None] * self.levers(state.angles)
        return torques

    @cached_property
    def knots(self) -> Knots:
        """Equilibria at evenly spaced forces between those at which a joint starts or stops."""
        starts = self.holding_force(np.zeros(len(self.upper)))
        stops = self.holding_force(self.upper)
        ends = np.unique(np.concatenate([starts, stops]))
        moving = (starts < ends[1:, None]) & (stops > ends[:-1, None])  # (intervals, n)
        some = moving.any(axis=1)
        moving = moving[some, None]
        forces = np.linspace(ends[:-1][some], ends[1:][some], _PIECES + 1, axis=1)
        angles = self._angles_at(forces)  # (intervals, pieces + 1, n)
        compliance = np.where(moving, 1.0 / self._force_slope(angles), 0.0)
        slopes = compliance / (compliance @ self.shortening_per_rad)[..., None]
        first, last = (part.reshape(-1, len(starts)) for part in (slopes[:, :-1], slopes[:, 1:]))
        knots = np.vstack([angles[:, :-1].reshape(first.shape), self.upper])
        return Knots(knots @ self.shortening_per_rad, knots, first, last, float(stops.max()))

    def _angles_at(self, forces: Array) -> Array:
        """(..., n) angles at which forces (...,) hold the joints, by bisection to rounding."""
        forces = forces[..., None]
        low = np.zeros((*forces.shape[:-1], len(self.upper)))
        high = np.broadcast_to(self.upper, low.shape)
        for _ in range(60):
            middle = (low + high) / 2
            below = self.holding_force(middle) < forces
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        at_stop = self.holding_force(self.upper) <= forces
        open_ = self.holding_force(np.zeros(len(self.upper))) >= forces
        angles: Array = np.where(at_stop, self.upper, np.where(open_, 0.0, (low + high) / 2))
        return angles

    def _force_slope(self, angles: Array) -> Array:
        """dF_i/dθ (..., n) [N/rad]."""
        force = self.holding_force(angles)
        slope: Array = force / (angles + self.preload)
        if self.lever == "growing":
            slope = slope - force / (2.0 * np.tan(np.pi / 4 + angles / 2))
        return slope

    @property
    def _force_scale(self) -> Array:
        """(n,) the part of the lever that does not depend on the angle [m]."""
        if self.lever == "constant":
            return self.shortening_per_rad
        return np.sqrt(2.0) * self.lever_open_m


@njit(cache=True)
def solve(
    wanted: Array,
    knots: Knots,
    stiffness: Array,
    preload: Array,
    scale: Array,
    per_rad: Array,
    growing: bool,
    angles: Array,
    tension: Array,
) -> None:
    """Fill angles (k, n) and tension (k,) for shortenings (k,)."""
    force, give = np.empty(len(stiffness)), np.empty(len(stiffness))
    for k in range(len(wanted)):
        if wanted[k] <= 0.0:
            angles[k] = 0.0
            tension[k] = 0.0
            continue
        if wanted[k] >= knots.shortening[-1]:
            angles[k] = knots.angles[-1]
            tension[k] = knots.stop_n
            continue
        piece = _piece_of(wanted[k], knots.shortening)
        _interpolate(wanted[k], piece, knots, angles[k])
        for _ in range(_MOST_STEPS):
            for i in range(len(force)):
                force[i], give[i] = 0.0, 0.0
                if knots.first_slope[piece, i] > 0.0:
                    force[i], give[i] = _force(
                        stiffness[i], preload[i], scale[i], growing, angles[k, i]
                    )
            tension[k], step = _newton_step(wanted[k], per_rad, force, give, angles[k])
            if step < _LAST_STEP_RAD:
                break
        for i in range(len(force)):
            angles[k, i] = min(max(angles[k, i], 0.0), knots.angles[-1, i])


@njit(cache=True)
def _piece_of(wanted: float, shortening: Array) -> int:
    """Index of the last knot at or below a shortening, by bisection."""
    low, high = 0, len(shortening) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if shortening[middle] <= wanted:
            low = middle
        else:
            high = middle
    return low


@njit(cache=True)
def _interpolate(wanted: float, piece: int, knots: Knots, angles: Array) -> None:
    """Cubic Hermite interpolation of the angles (n,) within a piece; resting joints keep theirs."""
    width = knots.shortening[piece + 1] - knots.shortening[piece]
    t = (wanted - knots.shortening[piece]) / width
    s = 1.0 - t
    for i in range(len(angles)):
        a, b = knots.angles[piece, i], knots.angles[piece + 1, i]
        rise_a, rise_b = width * knots.first_slope[piece, i], width * knots.last_slope[piece, i]
        curve = s * (rise_a - (b - a)) + t * ((b - a) - rise_b)
        angles[i] = a + t * ((b - a) + s * curve)


@njit(cache=True)
def _newton_step(
    wanted: float, per_rad: Array, force: Array, give: Array, angles: Array
) -> tuple[float, float]:
    """One step of Newton's method on the moving joints and the tension.

    Linear in the step, F_i + δ_i / give_i = F for every moving joint and Σ per_rad (θ + δ) = ΔL:
    the δ_i = give_i (F - F_i) follow from F = (ΔL - Σ per_rad (θ - give F_i)) / Σ per_rad give.
    Joints at rest have no give.

    Returns:
        Tension [N] and the largest change of an angle [rad].
    """
    missing, compliance = wanted, 0.0
    for i in range(len(angles)):
        missing += per_rad[i] * (give[i] * force[i] - angles[i])
        compliance += per_rad[i] * give[i]
    tension, largest = missing / compliance, 0.0
    for i in range(len(angles)):
        step = (tension - force[i]) * give[i]
        angles[i] += step
        largest = max(largest, abs(step))
    return tension, largest


@njit(cache=True)
def _force(
    stiffness: float, preload: float, scale: float, growing: bool, angle: float
) -> tuple[float, float]:
    """F_i(θ) and dθ/dF."""
    if not growing:
        return stiffness * (angle + preload) / scale, scale / stiffness
    s = np.sin(np.pi / 4 + angle / 2)
    c = np.sqrt(1.0 - s * s)  # Cheaper than a cosine; the slope need not be exact to rounding
    spring = stiffness * (angle + preload)
    return spring / (scale * s), scale * s * s / (stiffness * s - 0.5 * spring * c)


# Table 4.4: proximal, medial, distal. The spring constants are in N mm per degree, the unit that
# opens a finger of this mass.
SEGMENT_LENGTHS_M = np.array([0.060, 0.039, 0.030])


def thesis_finger(lever: Lever = "growing") -> TendonFinger:
    """The finger of ARMAR-6's hand as table 4.4 has it."""
    return TendonFinger(
        stiffness=np.rad2deg([0.67e-3, 0.82e-3, 0.82e-3]),
        preload=np.deg2rad([30.0, 30.0, 35.0]),
        lever_open_m=np.full(3, 7.5e-3),
        length_m=np.full(3, 15e-3),
        upper=np.full(3, np.pi / 2),
        lever=lever,
    )
