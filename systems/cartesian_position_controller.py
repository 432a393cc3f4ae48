"""Cartesian position control of the hand as a LeafSystem."""

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context

from vh_drake.control.cartesian_position import (
    GAIN_PER_S,
    MAX_ANGULAR_RAD_S,
    MAX_LINEAR_M_S,
    cartesian_position_velocity,
)
from vh_drake.systems.collectable import CollectableSystem


class CartesianPositionController(CollectableSystem):
    """Bounded velocity that moves the hand to its target pose.

    .. pydrake_system::

        name: CartesianPositionController
        input_ports:
        - target_pose
        - hand_pose
        - target_velocity
        output_ports:
        - spatial_velocity

    ==================  =========  ==============  ==========  ================================
    name                direction  type            unit        meaning
    ==================  =========  ==============  ==========  ================================
    target_pose         in         RigidTransform  m           hand pose X_WH to reach
    hand_pose           in         RigidTransform  m           hand pose X_WH now
    target_velocity     in         vector (6)      rad/s, m/s  of the target; may be left open
    spatial_velocity    out        vector (6)      rad/s, m/s  of H in W, angular part first
    ==================  =========  ==============  ==========  ================================

    Args:
        gain_per_s: velocity over error near the target.
        max_angular_rad_s: bound of the angular velocity.
        max_linear_m_s: bound of the linear velocity.
    """

    def __init__(
        self,
        *,
        gain_per_s: float = GAIN_PER_S,
        max_angular_rad_s: float = MAX_ANGULAR_RAD_S,
        max_linear_m_s: float = MAX_LINEAR_M_S,
    ) -> None:
        super().__init__()
        self._gain_per_s = gain_per_s
        self._max_angular_rad_s = max_angular_rad_s
        self._max_linear_m_s = max_linear_m_s
        self._target = self.DeclareAbstractInputPort("target_pose", Value(RigidTransform()))
        self._hand = self.DeclareAbstractInputPort("hand_pose", Value(RigidTransform()))
        self._velocity = self.DeclareVectorInputPort("target_velocity", 6)
        inputs = (self._target, self._hand, self._velocity)
        self.DeclareVectorOutputPort(
            "spatial_velocity",
            6,
            self._calc_spatial_velocity,
            prerequisites_of_calc={port.ticket() for port in inputs},
        )

    def _calc_spatial_velocity(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(
            cartesian_position_velocity(
                self._target.Eval(context).GetAsMatrix4(),
                self._hand.Eval(context).GetAsMatrix4(),
                V_WH_target=self._velocity.Eval(context)
                if self._velocity.HasValue(context)
                else None,
                gain_per_s=self._gain_per_s,
                max_angular_rad_s=self._max_angular_rad_s,
                max_linear_m_s=self._max_linear_m_s,
            )
        )
