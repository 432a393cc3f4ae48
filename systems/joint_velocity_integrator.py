"""From commanded joint velocities to the desired state of the arm's joint servos."""

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from vh_drake.control.joint_limits import PERIOD_S, next_joint_state
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.errors import BadInput
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Array


class JointVelocityIntegrator(CollectableSystem):
    """Sums joint velocities up to commanded positions, within all limits of the joints.

    .. pydrake_system::

        name: JointVelocityIntegrator
        input_ports:
        - joint_velocity
        output_ports:
        - desired_state

    ==================  =========  ===========  ===========  ==================================
    name                direction  type         unit         meaning
    ==================  =========  ===========  ===========  ==================================
    joint_velocity      in         vector (8)   rad/s        commanded
    desired_state       out        vector (16)  rad, rad/s   commanded positions, velocities
    ==================  =========  ===========  ===========  ==================================

    Whatever velocities come in, the commanded ones keep the joints' velocity and acceleration
    limits, and the joints stop before their position limits (`limited_joint_velocity`).

    `desired_state` depends on the state alone, so it may be fed back as the controllers'
    `joint_state` without an algebraic loop; then servo errors don't drift into the command.

    Args:
        kinematics: the arm, for its limits.
        initial_q: joint positions (8,) [rad] at the start; the home configuration by default.
        period_s: time between updates.

    Raises:
        BadInput: `initial_q` is not (8,) or outside the joint limits.
    """

    def __init__(
        self,
        kinematics: ArmKinematics,
        initial_q: Array | None = None,
        *,
        period_s: float = PERIOD_S,
    ) -> None:
        super().__init__()
        self._kinematics = kinematics
        self._period_s = period_s
        q = self._checked(kinematics.home if initial_q is None else initial_q)
        self._velocity = self.DeclareVectorInputPort("joint_velocity", 8)
        state = self.DeclareDiscreteState(np.concatenate([q, np.zeros(8)]))
        self.DeclareStateOutputPort("desired_state", state)
        self.DeclarePeriodicDiscreteUpdateEvent(period_s, 0.0, self._step)

    def set_positions(self, context: Context, q: Array) -> None:
        """Command joint positions (8,) [rad], at rest, in this system's own context."""
        context.SetDiscreteState(np.concatenate([self._checked(q), np.zeros(8)]))

    def _step(self, context: Context, values: DiscreteValues) -> None:
        now = context.get_discrete_state_vector().value()
        wanted, limits = self._velocity.Eval(context), self._kinematics.limits
        values.set_value(next_joint_state(wanted, now, limits, period_s=self._period_s))

    def _checked(self, q: Array) -> Array:
        arm = self._kinematics
        q = np.asarray(q, dtype=float)
        if q.shape != (8,) or not np.all((arm.lower <= q) & (q <= arm.upper)):
            raise BadInput(
                f"joint positions {np.round(q, 3).tolist()} are not 8 numbers between "
                f"{np.round(arm.lower, 3).tolist()} and {np.round(arm.upper, 3).tolist()}"
            )
        return q
