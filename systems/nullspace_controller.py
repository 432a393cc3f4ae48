"""Null-space control of the arm (eq. 4.2 to 4.7) as a LeafSystem."""

from pydrake.systems.framework import BasicVector, Context

from vh_drake.control.joint_limits import limited_joint_velocity
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.null_space import GAIN, add_null_space_velocity
from vh_drake.systems.collectable import CollectableSystem


class NullspaceController(CollectableSystem):
    """Adds to joint velocities what moves joints off their limits and leaves the hand alone.

    .. pydrake_system::

        name: NullspaceController
        input_ports:
        - joint_state
        - joint_velocity
        output_ports:
        - joint_velocity

    ==================  =========  ===========  ===========  ==================================
    name                direction  type         unit         meaning
    ==================  =========  ===========  ===========  ==================================
    joint_state         in         vector (16)  rad, rad/s   positions, then velocities
    joint_velocity      in         vector (8)   rad/s        wanted by the Cartesian control
    joint_velocity      out        vector (8)   rad/s        with limit avoidance added
    ==================  =========  ===========  ===========  ==================================

    Args:
        kinematics: the arm.
        gain: p_N; 1 to 2 suits most motions, 0 switches the avoidance off.
        period_s: of the commands, where nothing comes after this system that limits
            accelerations: then it does, from the velocities of `joint_state` on.
    """

    def __init__(
        self, kinematics: ArmKinematics, *, gain: float = GAIN, period_s: float | None = None
    ) -> None:
        super().__init__()
        self._period_s = period_s
        self._kinematics = kinematics
        self._gain = gain
        self._state = self.DeclareVectorInputPort("joint_state", 16)
        self._velocity = self.DeclareVectorInputPort("joint_velocity", 8)
        self.DeclareVectorOutputPort(
            "joint_velocity",
            8,
            self._calc_joint_velocity,
            prerequisites_of_calc={self._state.ticket(), self._velocity.ticket()},
        )

    def _calc_joint_velocity(self, context: Context, output: BasicVector) -> None:
        arm = self._kinematics
        state = self._state.Eval(context)
        q, now = state[:8], state[8:]
        velocity = add_null_space_velocity(
            self._velocity.Eval(context),
            arm.jacobian(q),
            q,
            lower=arm.lower,
            upper=arm.upper,
            velocity_limits=arm.velocity_limits,
            gain=self._gain,
        )
        if self._period_s is not None:
            velocity = limited_joint_velocity(velocity, q, now, arm.limits, period_s=self._period_s)
        output.SetFromVector(velocity)
