"""Rating grasp candidates as a LeafSystem."""

from collections.abc import Callable

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, EventStatus, LeafSystem, State

from vh_drake.types import Candidates, GraspScores, ObjectView, Surface

Scorer = Callable[[Candidates, Surface, ObjectView], GraspScores]


class GraspScorer(LeafSystem):
    """Rates and ranks grasp candidates by any scorer, when asked.

    .. pydrake_system::

        name: GraspScorer
        input_ports:
        - candidates
        - surface
        - object_view
        - request
        output_ports:
        - scores
        - ranking
        - served

    | port        | direction | type        | unit | meaning                                     |
    |-------------|-----------|-------------|------|---------------------------------------------|
    | candidates  | in        | Candidates  | m    | what to rate                                |
    | surface     | in        | Surface     | m    | the estimate                                |
    | object_view | in        | ObjectView  | m    | segmented object and table                  |
    | request     | in        | vector (1)  |      | an id; a new one asks for a rating, 0: no   |
    | scores      | out       | GraspScores |      | in the order of the candidates              |
    | ranking     | out       | tuple       |      | indices of the candidates, best first       |
    | served      | out       | vector (1)  |      | id of the request that they answer          |

    A request is answered at the next of the periodic looks (an event), which takes the inputs of
    that instant: connect `request` to the planner's `served`, so that its candidates are there.
    Equal scores keep the candidates' order.

    Args:
        score: rates candidates on a surface, deterministically.
        period_s: between looks at the request.
    """

    def __init__(self, score: Scorer, period_s: float = 0.02) -> None:
        super().__init__()
        self._score = score
        self._candidates = self.DeclareAbstractInputPort("candidates", Value[object](Candidates()))
        self._surface = self.DeclareAbstractInputPort("surface", Value[object](Surface()))
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))
        self._request = self.DeclareVectorInputPort("request", 1)
        self._scores = self.DeclareAbstractState(Value[object](GraspScores()))
        self._ranking = self.DeclareAbstractState(Value[object](()))
        self._served = self.DeclareDiscreteState(1)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period_s, 0.0, self._serve)
        self.DeclareStateOutputPort("scores", self._scores)
        self.DeclareStateOutputPort("ranking", self._ranking)
        self.DeclareVectorOutputPort(
            "served", 1, self._calc_served, prerequisites_of_calc={self.xd_ticket()}
        )

    def _serve(self, context: Context, state: State) -> EventStatus:
        request = self._request.Eval(context)[0]
        if request in (0.0, context.get_discrete_state(self._served)[0]):
            return EventStatus.DidNothing()
        scores = self._score(
            self._candidates.Eval(context), self._surface.Eval(context), self._view.Eval(context)
        )
        state.get_mutable_abstract_state(self._scores).set_value(scores)
        state.get_mutable_abstract_state(self._ranking).set_value(ranking(scores))
        state.get_mutable_discrete_state(self._served).set_value([request])
        return EventStatus.Succeeded()

    def _calc_served(self, context: Context, output: BasicVector) -> None:
        output[0] = context.get_discrete_state(self._served)[0]


def ranking(scores: GraspScores) -> tuple[int, ...]:
    """Indices of candidates, best first; among equals the first comes first."""
    return tuple(int(i) for i in np.argsort(-scores.score, kind="stable"))
