r"""What keeps a real finger from closing as its springs alone would: friction, glove, weight.

Section 4.5.4 names them beside figure 4.18 and leaves them out of its model. While the finger
closes, each joint balances

.. math:: R_i(θ_i) F_i = K_i (θ_i + θ_{0,i}) + c_i + G_i \tanh(θ_i / θ_g) - W_i(θ)

- F_i: the tendon slides over the joints that it has passed, each of which leaves it only a part of
  its tension (Euler's belt formula, the wrap growing with the joint):
  :math:`F_i = F \exp(-μ \sum_{j<i} (φ + θ_j))`;
- c_i: friction in the joint, against the motion;
- G_i: the glove, which resists the first bend most and then folds: a spring that softens;
- W_i: the torque of the weight of the segments beyond the joint, in the closing direction.

Each effect may be zero; with all of them zero this is `TendonFinger`'s equilibrium. The joints
no longer move in turn by their own forces, so the equilibrium is followed from the open finger on.
"""

import dataclasses as dc

import numpy as np

from vh_drake.errors import BadInput, VhDrakeError
from vh_drake.hand.tendon_finger import Equilibrium, TendonFinger
from vh_drake.types import Array

GRAVITY_M_S2 = 9.81
_MOST_STEPS = 50
_TOLERANCE_RAD = 1e-12
_LONGEST_STEP_RAD = 0.3
_TAUT_N_M = 1e4  # tension that a missing length asks for, to tell a slack tendon from a taut one


@dc.dataclass(frozen=True, eq=False)
class FingerEffects:
    """Parameters of a finger of n joints; the defaults have no effect.

    Attributes:
        tendon_friction: μ between tendon and routing.
        wrap_rad: φ, by which the tendon bends at an open joint.
        joint_friction_nm: c_i (n,).
        glove_nm: G_i (n,), the glove's torque at a bent joint.
        glove_angle_rad: θ_g, the bend at which it has three quarters of it.
        mass_kg: of the segments (n,), their centres in the middle.
        segment_m: lengths of the segments (n,).
        down_rad: direction of gravity in the finger's plane, from the open finger towards the
            side to which it closes: 90 degrees with the palm down, 0 with the fingers down.
    """

    tendon_friction: float = 0.0
    wrap_rad: float = 0.0
    joint_friction_nm: Array = dc.field(default_factory=lambda: np.zeros(3))
    glove_nm: Array = dc.field(default_factory=lambda: np.zeros(3))
    glove_angle_rad: float = 0.1
    mass_kg: Array = dc.field(default_factory=lambda: np.zeros(3))
    segment_m: Array = dc.field(default_factory=lambda: np.ones(3))
    down_rad: float = np.pi / 2

    def __post_init__(self) -> None:
        numbers = [np.ravel(getattr(self, field.name)) for field in dc.fields(self)]
        signed = numbers.pop()
        if not all(np.isfinite(values).all() and np.all(values >= 0) for values in numbers):
            raise BadInput(f"a finger's friction, glove and masses can't be negative: {self}")
        if not (np.isfinite(signed).all() and self.glove_angle_rad > 0):
            raise BadInput(f"glove_angle_rad and down_rad must be usable angles: {self}")

    def tension_shares(self, angles: Array) -> Array:
        """F_i / F (n,) at joint angles (n,)."""
        wrapped = np.cumsum(self.wrap_rad + angles) - (self.wrap_rad + angles)
        shares: Array = np.exp(-self.tendon_friction * wrapped)
        return shares

    def weight_torques(self, angles: Array) -> Array:
        """W_i (n,) [N m]: positive where the weight closes the joint."""
        directions = np.cumsum(angles) - self.down_rad  # of the segments, from that of gravity
        # By sin, how far to the side of gravity's line a segment reaches: the arm of a weight.
        reach = -self.segment_m * np.sin(directions)
        beyond = np.cumsum(self.mass_kg[::-1])[::-1] - self.mass_kg
        moments = (beyond + self.mass_kg / 2) * reach
        torques: Array = GRAVITY_M_S2 * np.cumsum(moments[::-1])[::-1]
        return torques

    def resistance(self, angles: Array) -> Array:
        """What the tendon must overcome beside the springs (n,): c + G tanh(θ / θ_g) - W [N m]."""
        glove = self.glove_nm * np.tanh(angles / self.glove_angle_rad)
        resistance: Array = self.joint_friction_nm + glove - self.weight_torques(angles)
        return resistance


def closing(finger: TendonFinger, effects: FingerEffects, shortening_m: Array) -> Equilibrium:
    """Joints and tension of a finger that closes from its open stops.

    Args:
        finger: tendon and springs of n joints.
        effects: friction, glove and weight of as many.
        shortening_m: ascending (k,), from 0 on; each equilibrium starts from the one before.

    Raises:
        BadInput: the shortenings don't ascend within the joints' range, or the numbers of joints
            differ.
        VhDrakeError: no equilibrium is found; take finer steps or weaker effects.
    """
    shortening = np.asarray(shortening_m, np.float64)
    if not (np.all(np.diff(shortening) > 0) and shortening[0] >= 0):
        raise BadInput("shortenings must ascend from 0 or more")
    if not shortening[-1] <= finger.closed_m * (1 + 1e-12):
        raise BadInput(f"shortenings end at {shortening[-1]:g} m, above {finger.closed_m:g} m")
    if not len(effects.glove_nm) == len(effects.mass_kg) == len(finger.upper):
        raise BadInput("finger and effects must have the same number of joints")
    state = np.concatenate([np.zeros(len(finger.upper)), [0.0]])
    states = []
    for wanted in shortening:
        state = _equilibrium(finger, effects, min(wanted, finger.closed_m), state)
        states.append(state)
    found = np.array(states)
    return Equilibrium(found[:, :-1], found[:, -1])


def _equilibrium(
    finger: TendonFinger, effects: FingerEffects, wanted: float, state: Array
) -> Array:
    """Angles and tension (n + 1,), by Newton's method on what is not at a limit.

    A joint rests at a stop where the torque that is left over would push it farther, and the
    tendon is slack where the finger hangs farther closed than it is pulled.
    """
    lowest, highest = np.zeros(len(state)), np.append(finger.upper, np.inf)
    softness = np.append(1.0 / finger.stiffness, _TAUT_N_M)
    for _ in range(_MOST_STEPS):
        residual, jacobian = _residual(finger, effects, wanted, state)
        goal = state + softness * residual
        resting = (goal <= lowest) | (goal >= highest)
        if resting[:-1].all() and residual[-1] > 0:  # The strongest joint leaves its stop.
            resting[np.argmax(np.where(goal[:-1] < finger.upper, residual[:-1], -np.inf))] = False
        residual[resting] = (state - np.clip(goal, lowest, highest))[resting]
        jacobian[resting] = np.eye(len(state))[resting]
        step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
        state = state + step * min(1.0, _LONGEST_STEP_RAD / max(np.abs(step[:-1]).max(), 1e-12))
        if np.abs(step[:-1]).max() < _TOLERANCE_RAD:
            return state
    raise VhDrakeError(
        f"no equilibrium found at a shortening of {wanted:g} m; take finer steps or weaker effects"
    )


def _residual(
    finger: TendonFinger, effects: FingerEffects, wanted: float, state: Array
) -> tuple[Array, Array]:
    """Torques that close (n,) and missing shortening, with their derivatives (n + 1, n + 1)."""

    def value(z: Array) -> Array:
        angles, tension = z[:-1], z[-1]
        pull = finger.levers(angles) * tension * effects.tension_shares(angles)
        spring = finger.stiffness * (angles + finger.preload)
        missing = wanted - finger.shortening_per_rad @ angles
        return np.append(pull - spring - effects.resistance(angles), missing)

    h = 1e-30  # complex steps: derivatives without cancellation
    columns = [np.imag(value(state + 1j * h * axis)) / h for axis in np.eye(len(state))]
    return value(state), np.stack(columns, axis=1)
