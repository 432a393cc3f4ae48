"""Contact estimation from the wrist's force-torque sensor as a LeafSystem."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from vh_drake.sensing.contact_point import Skin
from vh_drake.sensing.ft_contact import (
    FtContactModel,
    FtContactSettings,
    FtSample,
    FtState,
    force_of,
    has_contact,
)
from vh_drake.sensing.hand_load import HandInertia
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import ContactSet


class FtContactEstimator(CollectableSystem):
    """Tells whether, where and how the hand touches something (thesis, eq. 4.8).

    .. pydrake_system::

        name: FtContactEstimator
        input_ports:
        - wrist_wrench
        - hand_pose
        - hand_velocity
        - hand_acceleration
        - tare
        - approach_direction
        output_ports:
        - contact
        - contact_point
        - force

    | port               | direction | type           | unit       | meaning                       |
    |--------------------|-----------|----------------|------------|-------------------------------|
    | wrist_wrench       | in        | vector (6)     | N m, N     | [torque; force] about Ho in H |
    | hand_pose          | in        | RigidTransform | m          | X_WH                          |
    | hand_velocity      | in        | vector (6)     | rad/s, m/s | [w; v] of H in W              |
    | hand_acceleration  | in        | vector (6)     | *          | its rate, rad/s², m/s²        |
    | tare               | in        | vector (1)     | -          | id; a change latches F_0      |
    | approach_direction | in        | vector (3)     | -          | of motion, in W; 0 if unknown |
    | contact            | out       | vector (1)     | -          | 1: touched since the tare     |
    | contact_point      | out       | ContactSet     | m          | none or one, in W             |
    | force              | out       | vector (3)     | N          | F - F_0 on the hand, in W     |

    The wrench is the load that the hand puts on the arm: at rest its weight (`WristSensor`).
    What the hand's motion adds is taken off, so that wrench and acceleration must be of the same
    instant, or a hand that speeds up feels touches. Nothing touches before `tare` has changed
    from 0. The outputs change with the samples only.

    Args:
        skin: where the hand may touch, in the posture of the touch.
        inertia: mass properties of the hand.
        settings: the knobs, the sampling period among them.
    """

    def __init__(
        self,
        skin: Skin,
        inertia: HandInertia | None = None,
        settings: FtContactSettings | None = None,
    ) -> None:
        super().__init__()
        self._model = FtContactModel(skin, inertia, settings)
        self._wrench = self.DeclareVectorInputPort("wrist_wrench", 6)
        self._pose = self.DeclareAbstractInputPort("hand_pose", Value(RigidTransform()))
        self._velocity = self.DeclareVectorInputPort("hand_velocity", 6)
        self._acceleration = self.DeclareVectorInputPort("hand_acceleration", 6)
        self._tare = self.DeclareVectorInputPort("tare", 1)
        self._approach = self.DeclareVectorInputPort("approach_direction", 3)
        # Numbers, not an abstract state: at this rate an unrestricted update, which copies
        # the whole diagram's state, would cost more than the simulation.
        self.DeclareDiscreteState(FtState().to_vector())
        self.DeclarePeriodicDiscreteUpdateEvent(self._model.settings.period_s, 0.0, self._update)
        after = {self.xd_ticket()}
        self.DeclareVectorOutputPort("contact", 1, self._calc_contact, prerequisites_of_calc=after)
        self.DeclareAbstractOutputPort(
            "contact_point",
            lambda: Value[object](ContactSet()),
            self._calc_point,
            prerequisites_of_calc=after,
        )
        self.DeclareVectorOutputPort("force", 3, self._calc_force, prerequisites_of_calc=after)

    def _update(self, context: Context, values: DiscreteValues) -> None:
        X_WH = self._pose.Eval(context)
        sample = FtSample(
            wrench_H=self._wrench.Eval(context),
            R_WH=X_WH.rotation().matrix(),
            p_WH=X_WH.translation(),
            velocity_W=self._velocity.Eval(context),
            acceleration_W=self._acceleration.Eval(context),
            approach_W=self._approach.Eval(context),
            tare=float(self._tare.Eval(context)[0]),
        )
        state = context.get_discrete_state_vector().value()
        values.set_value(self._model.advance(state, sample))

    def _calc_contact(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, float(has_contact(context.get_discrete_state_vector().value())))

    def _calc_point(self, context: Context, output: Value) -> None:
        # A copy: what goes out must not change with the state.
        state = np.array(context.get_discrete_state_vector().value())
        output.set_value(FtState.from_vector(state).contact)

    def _calc_force(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(force_of(context.get_discrete_state_vector().value()))
