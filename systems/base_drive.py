"""Drives the carriage that bears a hand without its arm."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiscreteValues

from vh_drake.grasping.base_joints import base_pose, base_position
from vh_drake.hand.model import HandModel
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Array

PERIOD_S = 0.01


class BaseDrive(CollectableSystem):
    """Hand poses in, set points of the carriage's joints out.

    .. pydrake_system::

        name: BaseDrive
        input_ports:
        - target_pose
        output_ports:
        - base_state
        - hand_pose

    | port        | direction | type           | unit   | meaning                                 |
    |-------------|-----------|----------------|--------|-----------------------------------------|
    | target_pose | in        | RigidTransform | m      | X_WH where the hand shall be            |
    | base_state  | out       | vector (12)    | m, rad | positions of the joints, then rates     |
    | hand_pose   | out       | RigidTransform | m      | X_WH of it, as commanded                |

    The set points follow the target every 10 ms. The first step comes half a period after the
    start, when the target is known.

    Args:
        hand: on the carriage.
    """

    def __init__(self, hand: HandModel) -> None:
        super().__init__()
        self._hand = hand
        self._target = self.DeclareAbstractInputPort("target_pose", Value(RigidTransform()))
        state = self.DeclareDiscreteState(12)
        self.DeclareStateOutputPort("base_state", state)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD_S, PERIOD_S / 2, self._follow)
        self.DeclareAbstractOutputPort(
            "hand_pose",
            lambda: Value(RigidTransform()),
            self._calc_pose,
            prerequisites_of_calc={self.xd_ticket()},
        )

    def place(self, context: Context, X_WH: Array) -> Array:
        """Begin at X_WH (4, 4); returns the positions (6,) that the joints then have."""
        position = base_position(self._hand, X_WH)
        context.SetDiscreteState(np.r_[position, np.zeros(6)])
        return position

    def _follow(self, context: Context, values: DiscreteValues) -> None:
        before = context.get_discrete_state_vector().value()[:6]
        target = self._target.Eval(context).GetAsMatrix4()
        now = base_position(self._hand, target, before)
        values.set_value(np.concatenate([now, (now - before) / PERIOD_S]))

    def _calc_pose(self, context: Context, output: Value) -> None:
        position = context.get_discrete_state_vector().value()[:6]
        output.set_value(RigidTransform(base_pose(self._hand, position)))
