import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from vh_drake.errors import BadInput
from vh_drake.systems.grasp_scorer import GraspScorer
from vh_drake.types import Candidates, ContactSet, GraspScores, ObjectView, Surface

CANDIDATES = Candidates(np.tile(np.eye(4), (4, 1, 1)), ("side",) * 4, ("surface",) * 4)
SCORES = np.array([0.2, 0.9, 0.1, 0.9])


def given_scores(candidates, surface, view, contacts):
    return GraspScores(SCORES[: len(candidates)], np.full(len(candidates), 0.05))


def rated(system, request, *, caching=True):
    simulator = Simulator(system, system.CreateDefaultContext())
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    for name, value in (
        ("candidates", CANDIDATES),
        ("surface", Surface()),
        ("object_view", ObjectView()),
        ("contacts", ContactSet()),
    ):
        system.GetInputPort(name).FixValue(context, Value[object](value))
    system.GetInputPort("request").FixValue(context, [request])
    simulator.AdvanceTo(0.03)
    return [system.GetOutputPort(name).Eval(context) for name in ("scores", "ranking", "served")]


@pytest.mark.parametrize("caching", [True, False])
def test_the_ranking_is_best_first_and_equals_keep_their_order(caching):
    scores, ranking, served = rated(GraspScorer(given_scores), 2.0, caching=caching)
    np.testing.assert_array_equal(scores.score, SCORES)
    assert ranking == (1, 3, 0, 2)
    assert served[0] == 2.0


def test_two_contexts_of_one_scorer_are_independent():
    system = GraspScorer(given_scores)
    assert len(rated(system, 1.0)[1]) == 4
    assert rated(system, 0.0)[1] == ()


def test_a_scorer_that_refuses_its_input_says_so():
    def refuse(candidates, surface, view, contacts):
        raise BadInput("the estimated surface is empty; add points")

    with pytest.raises(BadInput, match="surface is empty"):
        rated(GraspScorer(refuse), 1.0)
