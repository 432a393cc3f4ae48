"""The fingertip that touches: where it is, and what it asks of the hand."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context

from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Array


class Fingertip(CollectableSystem):
    """A frame T fixed in the hand: its pose and velocity, and the hand's velocity for it.

    .. pydrake_system::

        name: Fingertip
        input_ports:
        - hand_pose
        - hand_velocity
        - tip_command
        output_ports:
        - fingertip_pose
        - fingertip_velocity
        - hand_command

    | port               | direction | type           | unit       | meaning                       |
    |--------------------|-----------|----------------|------------|-------------------------------|
    | hand_pose          | in        | RigidTransform | m          | X_WH                          |
    | hand_velocity      | in        | vector (6)     | rad/s, m/s | [w; v] of H in W              |
    | tip_command        | in        | vector (6)     | rad/s, m/s | wanted [w; v] of T in W       |
    | fingertip_pose     | out       | RigidTransform | m          | X_WT                          |
    | fingertip_velocity | out       | vector (6)     | rad/s, m/s | [w; v] of T in W              |
    | hand_command       | out       | vector (6)     | rad/s, m/s | [w; v] of H that moves T so   |

    Args:
        X_HT: the frame in the hand (4, 4).
    """

    def __init__(self, X_HT: Array) -> None:
        super().__init__()
        self._X_HT = RigidTransform(np.array(X_HT))
        self._pose = self.DeclareAbstractInputPort("hand_pose", Value(RigidTransform()))
        self._velocity = self.DeclareVectorInputPort("hand_velocity", 6)
        self._command = self.DeclareVectorInputPort("tip_command", 6)
        pose = self._pose.ticket()
        self.DeclareAbstractOutputPort(
            "fingertip_pose",
            lambda: Value(RigidTransform()),
            self._calc_pose,
            prerequisites_of_calc={pose},
        )
        self.DeclareVectorOutputPort(
            "fingertip_velocity",
            6,
            self._calc_velocity,
            prerequisites_of_calc={pose, self._velocity.ticket()},
        )
        self.DeclareVectorOutputPort(
            "hand_command",
            6,
            self._calc_command,
            prerequisites_of_calc={pose, self._command.ticket()},
        )

    def _lever(self, context: Context) -> Array:
        """From H to T, in W (3,) [m]."""
        lever: Array = self._pose.Eval(context).rotation() @ self._X_HT.translation()
        return lever

    def _calc_pose(self, context: Context, output: Value) -> None:
        output.set_value(self._pose.Eval(context) @ self._X_HT)

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        V = self._velocity.Eval(context)
        output.SetFromVector(np.r_[V[:3], V[3:] + np.cross(V[:3], self._lever(context))])

    def _calc_command(self, context: Context, output: BasicVector) -> None:
        V = self._command.Eval(context)
        output.SetFromVector(np.r_[V[:3], V[3:] - np.cross(V[:3], self._lever(context))])
