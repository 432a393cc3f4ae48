"""Rating grasp candidates as a LeafSystem."""

from collections.abc import Callable

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context

from vh_drake.systems.on_request import PERIOD_S, OnRequest
from vh_drake.types import Candidates, ContactSet, GraspScores, ObjectView, Surface

Scorer = Callable[[Candidates, Surface, ObjectView, ContactSet], GraspScores]


class GraspScorer(OnRequest):
    """Rates and ranks grasp candidates by any scorer, when asked.

    .. pydrake_system::

        name: GraspScorer
        input_ports:
        - request
        - candidates
        - surface
        - object_view
        - contacts
        output_ports:
        - scores
        - ranking
        - served

    | port        | direction | type        | unit | meaning                                     |
    |-------------|-----------|-------------|------|---------------------------------------------|
    | request     | in        | vector (1)  |      | an id; a new one asks for a rating, 0: no   |
    | candidates  | in        | Candidates  | m    | what to rate                                |
    | surface     | in        | Surface     | m    | the estimate                                |
    | object_view | in        | ObjectView  | m    | segmented object and table                  |
    | contacts    | in        | ContactSet  | m    | touched places                              |
    | scores      | out       | GraspScores |      | in the order of the candidates              |
    | ranking     | out       | tuple       |      | indices of the candidates, best first       |
    | served      | out       | vector (1)  |      | id of the request that they answer          |

    Connect `request` to the planner's `served`, so that its candidates are there. Equal scores
    keep the candidates' order.

    Args:
        score: rates candidates on a surface, deterministically.
        period_s: between looks at the request.
    """

    def __init__(self, score: Scorer, period_s: float = PERIOD_S) -> None:
        super().__init__({"scores": GraspScores(), "ranking": ()}, period_s)
        self._score = score
        self._candidates = self.DeclareAbstractInputPort("candidates", Value[object](Candidates()))
        self._surface = self.DeclareAbstractInputPort("surface", Value[object](Surface()))
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object](ContactSet()))

    def answer(self, context: Context) -> tuple[GraspScores, tuple[int, ...]]:
        """Scores and ranking."""
        inputs = (self._candidates, self._surface, self._view, self._contacts)
        scores = self._score(*(port.Eval(context) for port in inputs))
        return scores, ranking(scores)


def ranking(scores: GraspScores) -> tuple[int, ...]:
    """Indices of candidates, best first; among equals the first comes first."""
    return tuple(int(i) for i in np.argsort(-scores.score, kind="stable"))
