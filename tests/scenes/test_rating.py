import dataclasses as dc

import numpy as np
import pytest
import torch
from lift_models import linear_model
from scenery import can_surface, can_view, right_hand

from vh_drake.errors import BadInput
from vh_drake.gpis.surface import estimate_surface
from vh_drake.grasping.closure_rate import PerturbationSettings
from vh_drake.grasping.field import object_field
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.grasping.scoring import ScoringSettings, score_candidates
from vh_drake.learning.calibration import Calibration
from vh_drake.learning.labels import (
    LabelSettings,
    guarded_rates,
    nominal_closure,
    nominal_epsilon,
)
from vh_drake.learning.lift_model import FILE, save_lift_model
from vh_drake.learning.metric import GraspMetric, load_metric, save_metric
from vh_drake.learning.network import GraspNetwork
from vh_drake.scenes.rating import (
    conventional_scorer,
    learned_rating,
    learned_scorer,
    make_scorer,
    scorer_in_use,
)
from vh_drake.types import Candidates, ContactSet

SETTINGS = ScoringSettings(perturbation=PerturbationSettings(min_samples=8, max_samples=8))
NONE = ContactSet()
SLOPES = (2.0, 6.0)  # in the mean as many as odds of 4 make one number


@pytest.fixture(scope="module")
def estimate():
    return estimate_surface(can_view(), NONE)


@pytest.fixture(scope="module")
def candidates(estimate):
    settings = PlannerSettings(candidates=16, draws=60, rounds=2)
    return plan_candidates(estimate, can_view().table, right_hand(), settings, 0)


@pytest.fixture(scope="module")
def untrained():
    torch.manual_seed(0)
    card = {"hand": right_hand().description.name}
    return GraspMetric(GraspNetwork().eval(), Calibration(), Calibration(), card)


def test_the_conventional_scorer_rates_on_the_seen_table_with_its_seed(candidates):
    hand, surface, view = right_hand(), can_surface(), can_view()
    scores = conventional_scorer(hand, 7, SETTINGS)(candidates, surface, view, NONE)
    direct = score_candidates(candidates, surface, view.table, hand, SETTINGS, 7)
    np.testing.assert_array_equal(scores.score, direct.score)
    np.testing.assert_array_equal(scores.standard_error, direct.standard_error)
    assert len(scores.score) == len(candidates)


def test_the_learned_score_is_what_the_lift_model_makes_of_the_metric_s_word(
    candidates, estimate, untrained
):
    lift, scene = linear_model(untrained, SLOPES), (candidates, estimate, can_view(), NONE)
    rating = learned_rating(untrained, lift, right_hand(), 3, scene)
    success, spread = rating.told.success, rating.told.spread
    np.testing.assert_allclose(rating.lift, success, atol=1e-6)
    odds = np.log(success / (1 - success)) / 4
    one, other = (1 / (1 + np.exp(-slope * odds)) for slope in SLOPES)
    disagree = np.abs(one - other) / 2 / np.sqrt(2)
    assert spread.max() > 1e-3
    np.testing.assert_allclose(rating.error, np.hypot(disagree, spread), atol=1e-6)
    scores = learned_scorer(untrained, lift, right_hand(), 3)(*scene)
    np.testing.assert_array_equal(scores.score, rating.lift)
    np.testing.assert_array_equal(scores.standard_error, rating.error)


def test_the_same_seed_gives_the_same_learned_scores(candidates, estimate, untrained):
    score = learned_scorer(untrained, linear_model(untrained, SLOPES), right_hand(), 3)
    first, again = (score(candidates, estimate, can_view(), NONE) for _ in range(2))
    np.testing.assert_array_equal(first.score, again.score)
    np.testing.assert_array_equal(first.standard_error, again.standard_error)
    assert (first.score >= 0).all()
    assert (first.score <= 1).all()
    assert first.standard_error.max() > 0


def test_no_candidates_give_no_scores(estimate, untrained):
    scores = learned_scorer(untrained, linear_model(untrained, SLOPES), right_hand(), 0)(
        Candidates(), estimate, can_view(), NONE
    )
    assert len(scores.score) == 0


def test_a_touch_changes_what_the_learned_metric_says(candidates, estimate, untrained):
    def told(contacts):
        scene = (candidates, estimate, can_view(), contacts)
        return learned_rating(
            untrained, linear_model(untrained, SLOPES), right_hand(), 3, scene
        ).told.success

    touched = ContactSet(np.array([[0.745, -0.3, 0.95]]), np.array([[1.0, 0.0, 0.0]]))
    assert not np.array_equal(told(NONE), told(touched))


def test_a_hand_that_the_metric_never_learnt_with_is_rated_conventionally(candidates, estimate):
    hand = right_hand()
    foreign = dc.replace(hand, description=dc.replace(hand.description, name="another"))
    assert load_metric().card["hand"] == hand.description.name
    view = can_view()
    scores = make_scorer("learned", foreign, 1)(candidates, estimate, view, NONE)
    same = make_scorer("conventional", foreign, 1)(candidates, estimate, view, NONE)
    assert scorer_in_use("learned", foreign) == "conventional"
    assert scorer_in_use("epsilon", foreign) == "epsilon"
    assert scorer_in_use("learned", hand) == "learned"
    np.testing.assert_array_equal(scores.score, same.score)
    learned = make_scorer("learned", hand, 1)(candidates, estimate, view, NONE)
    assert not np.array_equal(learned.score, same.score)


@pytest.mark.parametrize("name", ["rate", "epsilon", "nominal"])
def test_a_baseline_is_its_measure_and_lots_decide_between_equals(name, candidates, estimate):
    hand, view = right_hand(), can_view()
    field, settings = object_field(estimate, view.table), LabelSettings(friction=0.8)
    rates = LabelSettings(min_samples=24, max_samples=100, target_error=0.05)
    expected = {
        "rate": lambda: guarded_rates(candidates, field, hand, rates, 3).rate,
        "epsilon": lambda: nominal_epsilon(candidates, field, hand, settings),
        "nominal": lambda: nominal_closure(candidates, field, hand, settings),
    }[name]()
    scores = make_scorer(name, hand, 3)(candidates, estimate, view, NONE).score
    np.testing.assert_allclose(scores, expected, atol=2e-6)
    assert len(set(scores)) == len(candidates)
    other = make_scorer(name, hand, 4)(candidates, estimate, view, NONE).score
    if name != "rate":  # which draws disturbances too
        assert 0 < np.abs(scores - other).max() < 2e-6
    assert len(make_scorer(name, hand, 3)(Candidates(), estimate, view, NONE).score) == 0


def test_weights_of_ones_own_rate_with_the_lift_model_beside_them(
    candidates, estimate, untrained, tmp_path
):
    path, hand, view = tmp_path / "mine.safetensors", right_hand(), can_view()
    save_metric(path, untrained)
    with pytest.raises(BadInput, match=r"lift_model\.json"):
        make_scorer("learned", hand, 3, str(path))
    save_lift_model(tmp_path / FILE, linear_model(load_metric(), SLOPES))
    with pytest.raises(BadInput, match="belongs to other weights"):
        make_scorer("learned", hand, 3, str(path))
    lift = linear_model(untrained, SLOPES)
    save_lift_model(tmp_path / FILE, lift)
    scores = make_scorer("learned", hand, 3, str(path))(candidates, estimate, view, NONE)
    expected = learned_scorer(untrained, lift, hand, 3)(candidates, estimate, view, NONE)
    np.testing.assert_allclose(scores.score, expected.score, atol=1e-6)
    with pytest.raises(BadInput, match="no file at"):
        scorer_in_use("learned", hand, str(tmp_path / "none.safetensors"))
