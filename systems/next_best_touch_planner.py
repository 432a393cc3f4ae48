"""Choice of the next touch as a LeafSystem."""

from collections.abc import Callable

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, EventStatus, LeafSystem, State

from vh_drake.exploration.next_touch import TouchSettings, plan_touch
from vh_drake.types import ContactSet, ObjectView, Surface, TouchPlan


class NextBestTouchPlanner(LeafSystem):
    """Ranks the places that a fingertip should touch next, when asked (IGEF, section 3.3.2).

    .. pydrake_system::

        name: NextBestTouchPlanner
        input_ports:
        - surface
        - object_view
        - contacts
        - fingertip_pose
        - fingertip_velocity
        - request
        output_ports:
        - plans
        - served

    | port               | direction | type             | unit      | meaning                     |
    |--------------------|-----------|------------------|-----------|-----------------------------|
    | surface            | in        | Surface          | m         | estimate                    |
    | object_view        | in        | ObjectView       | m         | what the camera saw; table  |
    | contacts           | in        | ContactSet       | m         | touches so far              |
    | fingertip_pose     | in        | RigidTransform   | m         | X_WT, z along the approach  |
    | fingertip_velocity | in        | vector (6)       | rad/s m/s | spatial velocity just before|
    |                    |           |                  |           | the last contact; 0: none   |
    | request            | in        | vector (1)       |           | a new id asks, 0: no        |
    | plans              | out       | tuple[TouchPlan] |           | best first; may be empty    |
    | served             | out       | vector (1)       |           | id that the plans answer    |

    Args:
        settings: strategy and limits.
        feasible: whether the arm can do a plan; None lets all pass.
        period_s: between looks at the request.
    """

    def __init__(
        self,
        settings: TouchSettings | None = None,
        feasible: Callable[[TouchPlan], bool] | None = None,
        period_s: float = 0.02,
    ) -> None:
        super().__init__()
        self._settings = settings or TouchSettings()
        self._feasible = feasible
        self._surface = self.DeclareAbstractInputPort("surface", Value[object](Surface()))
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object](ContactSet()))
        self._pose = self.DeclareAbstractInputPort("fingertip_pose", Value(RigidTransform()))
        self._velocity = self.DeclareVectorInputPort("fingertip_velocity", 6)
        self._request = self.DeclareVectorInputPort("request", 1)
        none: tuple[TouchPlan, ...] = ()
        self._plans = self.DeclareAbstractState(Value[object](none))
        self._served = self.DeclareDiscreteState(1)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period_s, 0.0, self._serve)
        self.DeclareStateOutputPort("plans", self._plans)
        self.DeclareVectorOutputPort(
            "served", 1, self._calc_served, prerequisites_of_calc={self.xd_ticket()}
        )

    def _serve(self, context: Context, state: State) -> EventStatus:
        request = self._request.Eval(context)[0]
        if request in (0.0, context.get_discrete_state(self._served)[0]):
            return EventStatus.DidNothing()
        plans = plan_touch(
            self._surface.Eval(context),
            self._view.Eval(context),
            self._contacts.Eval(context),
            self._pose.Eval(context),
            self._velocity.Eval(context)[3:],
            self._settings,
            self._feasible,
        )
        state.get_mutable_abstract_state(self._plans).set_value(plans)
        state.get_mutable_discrete_state(self._served).set_value([request])
        return EventStatus.Succeeded()

    def _calc_served(self, context: Context, output: BasicVector) -> None:
        output[0] = context.get_discrete_state(self._served)[0]
