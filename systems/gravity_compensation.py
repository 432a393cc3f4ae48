"""Torques that hold the arm against gravity, as a LeafSystem."""

from pydrake.systems.framework import BasicVector, Context

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.systems.collectable import CollectableSystem


class GravityCompensation(CollectableSystem):
    """Joint torques under which arm, hand and payload rest.

    .. pydrake_system::

        name: GravityCompensation
        input_ports:
        - joint_state
        output_ports:
        - torque

    ==================  =========  ===========  ===========  ==================================
    name                direction  type         unit         meaning
    ==================  =========  ===========  ===========  ==================================
    joint_state         in         vector (16)  rad, rad/s   positions, then velocities
    torque              out        vector (8)   N m          to add to the servos' torques
    ==================  =========  ===========  ===========  ==================================

    Args:
        kinematics: the arm; its payload counts.
    """

    def __init__(self, kinematics: ArmKinematics) -> None:
        super().__init__()
        self._kinematics = kinematics
        self._state = self.DeclareVectorInputPort("joint_state", 16)
        self.DeclareVectorOutputPort(
            "torque", 8, self._calc_torque, prerequisites_of_calc={self._state.ticket()}
        )

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._kinematics.gravity_torques(self._state.Eval(context)[:8]))
