"""Planning grasp candidates as a LeafSystem."""

from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, EventStatus, LeafSystem, State

from vh_drake.grasping.surface_planner import PlannerSettings, plan_candidates
from vh_drake.hand.model import HandModel
from vh_drake.types import Candidates, ObjectView, Surface


class GraspCandidatePlanner(LeafSystem):
    """Proposes grasps on an estimated surface, when asked.

    .. pydrake_system::

        name: GraspCandidatePlanner
        input_ports:
        - surface
        - object_view
        - request
        output_ports:
        - candidates
        - served

    | port        | direction | type       | unit | meaning                                    |
    |-------------|-----------|------------|------|--------------------------------------------|
    | surface     | in        | Surface    | m    | the estimate                               |
    | object_view | in        | ObjectView | m    | tells the table                            |
    | request     | in        | vector (1) |      | an id; a new one asks for a plan, 0: no    |
    | candidates  | out       | Candidates | m    | the last plan, maybe empty                 |
    | served      | out       | vector (1) |      | id of the request that it answers          |

    A request is answered at the next of the periodic looks (an event), which takes the inputs of
    that instant; the outputs only copy the state. The same inputs give the same plan.

    Args:
        hand: that shall grasp.
        settings: of the planner.
        seed: of its draws.
        period_s: between looks at the request.

    Raises:
        BadInput: at the event, where the surface is empty or open.
    """

    def __init__(
        self,
        hand: HandModel,
        settings: PlannerSettings | None = None,
        seed: int = 0,
        period_s: float = 0.02,
    ) -> None:
        super().__init__()
        self._hand = hand
        self._settings = settings or PlannerSettings()
        self._seed = seed
        self._surface = self.DeclareAbstractInputPort("surface", Value[object](Surface()))
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))
        self._request = self.DeclareVectorInputPort("request", 1)
        self._candidates = self.DeclareAbstractState(Value[object](Candidates()))
        self._served = self.DeclareDiscreteState(1)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period_s, 0.0, self._serve)
        self.DeclareStateOutputPort("candidates", self._candidates)
        self.DeclareVectorOutputPort(
            "served", 1, self._calc_served, prerequisites_of_calc={self.xd_ticket()}
        )

    def _serve(self, context: Context, state: State) -> EventStatus:
        request = self._request.Eval(context)[0]
        if request in (0.0, context.get_discrete_state(self._served)[0]):
            return EventStatus.DidNothing()
        candidates = plan_candidates(
            self._surface.Eval(context),
            self._view.Eval(context).table,
            self._hand,
            self._settings,
            self._seed,
        )
        state.get_mutable_abstract_state(self._candidates).set_value(candidates)
        state.get_mutable_discrete_state(self._served).set_value([request])
        return EventStatus.Succeeded()

    def _calc_served(self, context: Context, output: BasicVector) -> None:
        output[0] = context.get_discrete_state(self._served)[0]
