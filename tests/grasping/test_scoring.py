import dataclasses as dc

import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.grasping.closure_rate import PerturbationSettings
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.grasping.scoring import (
    ScoringSettings,
    rate_candidates,
    score_candidates,
    vertex_certainty,
)
from vh_drake.types import Candidates

PERTURBATION = PerturbationSettings(min_samples=16, max_samples=24)
SETTINGS = ScoringSettings(perturbation=PERTURBATION)


@pytest.fixture(scope="module")
def bar(standing):
    return standing(trimesh.creation.box([0.18, 0.04, 0.04]).subdivide().subdivide())


@pytest.fixture(scope="module")
def candidates(hand, table, bar):
    return plan_candidates(bar, table, hand, PlannerSettings(candidates=60, draws=200), 0)


@pytest.fixture(scope="module")
def rating(hand, table, bar, candidates):
    return rate_candidates(candidates, bar, table, hand, SETTINGS, 0)


def test_the_score_is_the_product_of_the_factors(hand, table, bar, candidates, rating):
    scores = score_candidates(candidates, bar, table, hand, SETTINGS, 0)
    product = rating.rate * rating.centered * rating.held * rating.certain * rating.placed
    np.testing.assert_allclose(scores.score, product)
    assert (scores.standard_error <= rating.standard_error).all()


def test_every_factor_lies_between_0_and_1_and_scores_differ(rating):
    for values in dc.asdict(rating).values():
        assert ((values >= 0) & (values <= 1)).all()
    assert rating.scores().score.max() > 0.3
    assert np.ptp(rating.scores().score) > 0.3


def test_a_grasp_at_the_end_of_a_bar_is_less_centered(hand, bar, candidates, rating):
    tcp = candidates.X_WH @ np.append(hand.description.tcps["power"], 1.0)
    offset = np.abs(tcp[:, 0] - 0.7)
    touching = rating.held > 0.5
    across = np.abs(candidates.X_WH[:, 1, 2]) > 0.7  # Fingers along y hold the bar's width.
    near, far = offset < 0.02, offset > 0.04
    assert (
        rating.centered[touching & across & near].mean()
        > rating.centered[touching & across & far].mean()
    )


def test_scores_do_not_depend_on_the_other_candidates(hand, table, bar, candidates, rating):
    few = Candidates(candidates.X_WH[:5], candidates.motion[:5], candidates.planner[:5])
    scores = score_candidates(few, bar, table, hand, SETTINGS, 0)
    np.testing.assert_array_equal(scores.score, rating.scores().score[:5])


def test_the_least_certain_vertex_counts_nothing():
    np.testing.assert_allclose(vertex_certainty(np.array([2.0, 3.0, 4.0]), 3), [1, 0.5, 0])


def test_without_variance_everything_is_certain():
    np.testing.assert_array_equal(vertex_certainty(np.zeros(0), 3), 1)
    np.testing.assert_array_equal(vertex_certainty(np.ones(3), 3), 1)


def test_no_candidates_have_no_scores(hand, table, bar):
    assert len(score_candidates(Candidates(), bar, table, hand, SETTINGS, 0).score) == 0


def test_an_unknown_motion_is_refused(hand, table, bar):
    odd = Candidates(np.eye(4)[None], ("throw",), ("surface",))
    with pytest.raises(BadInput, match="throw"):
        score_candidates(odd, bar, table, hand, SETTINGS, 0)
