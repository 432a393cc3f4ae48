"""Choice of the next touch as a LeafSystem."""

from collections.abc import Callable

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from vh_drake.exploration.next_touch import TouchSettings, plan_touch
from vh_drake.systems.on_request import PERIOD_S, OnRequest
from vh_drake.types import ContactSet, ObjectView, Surface, TouchPlan


class NextBestTouchPlanner(OnRequest):
    """Ranks the places that a fingertip should touch next, when asked (IGEF, section 3.3.2).

    .. pydrake_system::

        name: NextBestTouchPlanner
        input_ports:
        - request
        - surface
        - object_view
        - contacts
        - fingertip_pose
        - fingertip_velocity
        output_ports:
        - plans
        - served

    | port               | direction | type             | unit      | meaning                     |
    |--------------------|-----------|------------------|-----------|-----------------------------|
    | request            | in        | vector (1)       |           | a new id asks, 0: no        |
    | surface            | in        | Surface          | m         | estimate                    |
    | object_view        | in        | ObjectView       | m         | what the camera saw; table  |
    | contacts           | in        | ContactSet       | m         | touches so far              |
    | fingertip_pose     | in        | RigidTransform   | m         | X_WT, z along the approach  |
    | fingertip_velocity | in        | vector (6)       | rad/s m/s | spatial velocity just before|
    |                    |           |                  |           | the last contact; 0: none   |
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
        period_s: float = PERIOD_S,
    ) -> None:
        super().__init__({"plans": ()}, period_s)
        self._settings = settings or TouchSettings()
        self._feasible = feasible
        self._surface = self.DeclareAbstractInputPort("surface", Value[object](Surface()))
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object](ContactSet()))
        self._pose = self.DeclareAbstractInputPort("fingertip_pose", Value(RigidTransform()))
        self._velocity = self.DeclareVectorInputPort("fingertip_velocity", 6)

    def answer(self, context: Context) -> tuple[tuple[TouchPlan, ...]]:
        """The plans."""
        plans = plan_touch(
            self._surface.Eval(context),
            self._view.Eval(context),
            self._contacts.Eval(context),
            self._pose.Eval(context),
            self._velocity.Eval(context)[3:],
            self._settings,
            self._feasible,
        )
        return (plans,)
