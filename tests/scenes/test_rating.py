import numpy as np
from scenery import can_surface, can_view, right_hand

from vh_drake.grasping.closure_rate import PerturbationSettings
from vh_drake.grasping.scoring import ScoringSettings, score_candidates
from vh_drake.grasping.surface_planner import PlannerSettings, plan_candidates
from vh_drake.scenes.rating import conventional_scorer

SETTINGS = ScoringSettings(perturbation=PerturbationSettings(min_samples=8, max_samples=12))


def test_the_conventional_scorer_rates_on_the_seen_table_with_its_seed():
    hand, surface, view = right_hand(), can_surface(), can_view()
    candidates = plan_candidates(
        surface, view.table, hand, PlannerSettings(candidates=10, draws=60), 0
    )
    scores = conventional_scorer(hand, 7, SETTINGS)(candidates, surface, view)
    direct = score_candidates(candidates, surface, view.table, hand, SETTINGS, 7)
    np.testing.assert_array_equal(scores.score, direct.score)
    np.testing.assert_array_equal(scores.standard_error, direct.standard_error)
    assert len(scores.score) == len(candidates)
