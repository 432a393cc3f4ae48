"""Planning grasp candidates as a LeafSystem."""

from pydrake.common.value import Value
from pydrake.systems.framework import Context

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.model import HandModel
from vh_drake.systems.on_request import PERIOD_S, OnRequest
from vh_drake.types import Candidates, ObjectView, Surface


class GraspCandidatePlanner(OnRequest):
    """Proposes grasps on an estimated surface by the planners of its settings, when asked.

    .. pydrake_system::

        name: GraspCandidatePlanner
        input_ports:
        - request
        - surface
        - object_view
        output_ports:
        - candidates
        - served

    | port        | direction | type       | unit | meaning                                    |
    |-------------|-----------|------------|------|--------------------------------------------|
    | request     | in        | vector (1) |      | an id; a new one asks for a plan, 0: no    |
    | surface     | in        | Surface    | m    | the estimate                               |
    | object_view | in        | ObjectView | m    | tells the table                            |
    | candidates  | out       | Candidates | m    | the last plan, maybe empty                 |
    | served      | out       | vector (1) |      | id of the request that it answers          |

    The same inputs give the same plan.

    Args:
        hand: that shall grasp.
        settings: planners and approaches; both planners by default.
        seed: of all draws.
        arm: that carries the hand: poses out of its reach are left out. None: any pose will do.
        period_s: between looks at the request.

    Raises:
        BadInput: at the event, where the surface is empty or open.
    """

    def __init__(
        self,
        hand: HandModel,
        settings: PlannerSettings | None = None,
        seed: int = 0,
        *,
        arm: ArmKinematics | None = None,
        period_s: float = PERIOD_S,
    ) -> None:
        super().__init__({"candidates": Candidates()}, period_s)
        self._hand, self._arm = hand, arm
        self._settings = settings or PlannerSettings()
        self._seed = seed
        self._surface = self.DeclareAbstractInputPort("surface", Value[object](Surface()))
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))

    def answer(self, context: Context) -> tuple[Candidates]:
        """The plan."""
        surface, table = self._surface.Eval(context), self._view.Eval(context).table
        return (
            plan_candidates(surface, table, self._hand, self._settings, self._seed, arm=self._arm),
        )
