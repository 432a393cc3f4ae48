"""Cartesian velocity control of the hand as a LeafSystem."""

from pydrake.systems.framework import BasicVector, Context

from vh_drake.control.cartesian_velocity import SINGULAR_THRESHOLD, cartesian_velocity_to_joints
from vh_drake.control.joint_limits import limited_joint_velocity
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.systems.collectable import CollectableSystem


class CartesianVelocityController(CollectableSystem):
    """Joint velocities that give the hand a spatial velocity, by the pseudo-inverse Jacobian.

    .. pydrake_system::

        name: CartesianVelocityController
        input_ports:
        - spatial_velocity
        - joint_state
        output_ports:
        - joint_velocity

    ==================  =========  ===========  ===========  ==================================
    name                direction  type         unit         meaning
    ==================  =========  ===========  ===========  ==================================
    spatial_velocity    in         vector (6)   rad/s, m/s   of H in W, angular part first
    joint_state         in         vector (16)  rad, rad/s   positions, then velocities
    joint_velocity      out        vector (8)   rad/s        within the joints' limits
    ==================  =========  ===========  ===========  ==================================

    Args:
        kinematics: the arm.
        singular_threshold: singular values of the Jacobian below it are damped.
        period_s: of the commands, where nothing comes after this system that limits
            accelerations: then it does, from the velocities of `joint_state` on.
    """

    def __init__(
        self,
        kinematics: ArmKinematics,
        *,
        singular_threshold: float = SINGULAR_THRESHOLD,
        period_s: float | None = None,
    ) -> None:
        super().__init__()
        self._period_s = period_s
        self._kinematics = kinematics
        self._singular_threshold = singular_threshold
        self._velocity = self.DeclareVectorInputPort("spatial_velocity", 6)
        self._state = self.DeclareVectorInputPort("joint_state", 16)
        self.DeclareVectorOutputPort(
            "joint_velocity",
            8,
            self._calc_joint_velocity,
            prerequisites_of_calc={self._velocity.ticket(), self._state.ticket()},
        )

    def _calc_joint_velocity(self, context: Context, output: BasicVector) -> None:
        arm = self._kinematics
        state = self._state.Eval(context)
        q, now = state[:8], state[8:]
        velocity = cartesian_velocity_to_joints(
            self._velocity.Eval(context),
            arm.jacobian(q),
            q,
            lower=arm.lower,
            upper=arm.upper,
            velocity_limits=arm.velocity_limits,
            singular_threshold=self._singular_threshold,
        )
        if self._period_s is not None:
            velocity = limited_joint_velocity(velocity, q, now, arm.limits, period_s=self._period_s)
        output.SetFromVector(velocity)
