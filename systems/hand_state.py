"""Where the hand is and how it moves, from the arm's joints."""

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.systems.collectable import CollectableSystem


class HandState(CollectableSystem):
    """Forward kinematics of the arm.

    .. pydrake_system::

        name: HandState
        input_ports:
        - joint_state
        - joint_acceleration
        output_ports:
        - hand_pose
        - hand_velocity
        - hand_acceleration

    | port               | direction | type           | unit       | meaning                    |
    |--------------------|-----------|----------------|------------|----------------------------|
    | joint_state        | in        | vector (16)    | rad, rad/s | positions, then velocities |
    | joint_acceleration | in        | vector (8)     | rad/s²     | may be left open           |
    | hand_pose          | out       | RigidTransform | m          | X_WH                       |
    | hand_velocity      | out       | vector (6)     | rad/s, m/s | [w; v] of H in W           |
    | hand_acceleration  | out       | vector (6)     | *          | its rate, rad/s², m/s²     |

    The acceleration needs the joints' own.

    Args:
        kinematics: the arm.
    """

    def __init__(self, kinematics: ArmKinematics) -> None:
        super().__init__()
        self._kinematics = kinematics
        self._state = self.DeclareVectorInputPort("joint_state", 16)
        self._acceleration = self.DeclareVectorInputPort("joint_acceleration", 8)
        after = {self._state.ticket()}
        self.DeclareAbstractOutputPort(
            "hand_pose",
            lambda: Value(RigidTransform()),
            self._calc_pose,
            prerequisites_of_calc=after,
        )
        self.DeclareVectorOutputPort(
            "hand_velocity", 6, self._calc_velocity, prerequisites_of_calc=after
        )
        self.DeclareVectorOutputPort(
            "hand_acceleration",
            6,
            self._calc_acceleration,
            prerequisites_of_calc=after | {self._acceleration.ticket()},
        )

    def _calc_pose(self, context: Context, output: Value) -> None:
        q = self._state.Eval(context)[:8]
        output.set_value(RigidTransform(self._kinematics.pose(q)))

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        state = self._state.Eval(context)
        output.SetFromVector(self._kinematics.jacobian(state[:8]) @ state[8:])

    def _calc_acceleration(self, context: Context, output: BasicVector) -> None:
        state = self._state.Eval(context)
        output.SetFromVector(
            self._kinematics.acceleration(state[:8], state[8:], self._acceleration.Eval(context))
        )
