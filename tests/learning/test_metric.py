import shutil

import numpy as np
import pytest
import torch
from learning_scenes import can_estimate, can_scene
from scenery import right_hand

from vh_drake.errors import BadInput
from vh_drake.gpis.surface import estimate_surface
from vh_drake.grasping.field import object_field
from vh_drake.learning.calibration import Calibration, auc
from vh_drake.learning.features import fused_points, scene_fields
from vh_drake.learning.hints import hints_on_estimate
from vh_drake.learning.labels import SUCCESS_RATE
from vh_drake.learning.metric import (
    GraspMetric,
    golden_outputs,
    load_metric,
    save_metric,
    shipped_weights,
)
from vh_drake.learning.network import GraspNetwork
from vh_drake.learning.weights import card_path, load_weights, save_weights
from vh_drake.types import Candidates


def untrained(seed=0):
    torch.manual_seed(seed)
    calibration, blind = Calibration(0.9, 0.1), Calibration(1.1, -0.2)
    return GraspMetric(GraspNetwork().eval(), calibration, blind, {"hand": "some"})


@pytest.fixture(scope="module")
def scene():
    """Fields and hints of a labelled can."""
    made = can_scene()
    surface = estimate_surface(made.view, made.contacts)
    fields = scene_fields(made.view, made.contacts, surface)
    estimate = object_field(surface, made.view.table)
    fused = fused_points(made.view, made.contacts)
    return fields, hints_on_estimate(made.candidates, estimate, fused, right_hand(), 0)


def test_saved_and_loaded_it_says_the_same(scene, tmp_path):
    metric, candidates = untrained(), can_scene().candidates
    save_metric(tmp_path / "m.safetensors", metric)
    loaded = load_metric(tmp_path / "m.safetensors")
    for hints in (None, scene[1]):
        before = metric.predict(candidates, scene[0], hints)
        after = loaded.predict(candidates, scene[0], hints)
        np.testing.assert_array_equal(before.success, after.success)
        np.testing.assert_array_equal(before.rate, after.rate)
    assert loaded.card["hand"] == "some"


def test_probabilities_lie_between_zero_and_one_and_do_not_depend_on_company(scene):
    metric, candidates = untrained(), can_scene().candidates
    told = metric.predict(candidates, scene[0])
    assert ((told.success > 0) & (told.success < 1)).all()
    some = Candidates(candidates.X_WH[3:7], candidates.motion[3:7], candidates.planner[3:7])
    alone = metric.predict(some, scene[0])
    np.testing.assert_allclose(alone.success, told.success[3:7], atol=1e-6)


def test_the_spread_is_drawn_from_the_seed_and_asked_for(scene):
    metric, candidates = untrained(), can_scene().candidates
    none = metric.predict(candidates, scene[0])
    first, again = (metric.predict(candidates, scene[0], passes=6, seed=2) for _ in range(2))
    assert (none.spread == 0).all()
    assert (first.spread > 0).all()
    np.testing.assert_array_equal(first.spread, again.spread)
    np.testing.assert_array_equal(first.success, none.success)


def test_no_candidates_give_no_probabilities(scene):
    assert len(untrained().predict(Candidates(), scene[0]).success) == 0


def test_weights_of_another_network_are_refused(tmp_path):
    path = tmp_path / "m.safetensors"
    save_metric(path, untrained())
    arrays, card = load_weights(path)
    arrays["dense.bias"] = arrays["dense.bias"][:-1]
    save_weights(path, arrays, card)
    with pytest.raises(BadInput, match="another network"):
        load_metric(path)


@pytest.mark.parametrize("bad", [None, {"slope": -1.0, "offset": 0.0}, {"slope": "x"}, [1]])
def test_a_card_without_calibration_is_refused(tmp_path, bad):
    path = tmp_path / "m.safetensors"
    save_metric(path, untrained())
    arrays, card = load_weights(path)
    save_weights(path, arrays, {**card, "blind_calibration": bad})
    with pytest.raises(BadInput, match="blind_calibration"):
        load_metric(path)


def test_missing_or_damaged_weights_are_never_replaced_by_random_ones(tmp_path):
    with pytest.raises(BadInput, match="no file"):
        load_metric(tmp_path / "none.safetensors")
    path = tmp_path / "m.safetensors"
    save_metric(path, untrained())
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(BadInput, match="bytes"):
        load_metric(path)


def test_hints_tell_where_the_hand_closes_and_how_far_from_evidence(scene):
    hints, candidates = scene[1], can_scene().candidates
    assert (hints.contacts[hints.nominal] >= 3).all()
    assert (hints.max_guess >= hints.mean_guess - 1e-12).all()
    assert (hints.max_guess <= 0.06).all()
    assert np.abs(hints.offset[hints.fingers > 0]).max() < 0.15
    view, contacts, surface = can_estimate()
    everywhere = np.vstack([fused_points(view, contacts), surface.vertices])
    known = hints_on_estimate(
        candidates, object_field(surface, view.table), everywhere, right_hand(), 0
    )
    assert (known.max_guess[known.contacts > 0] < 0.006).all()


def test_the_shipped_metric_says_what_it_said_when_it_was_shipped():
    metric = load_metric()
    assert len(metric.card["golden"]) == 8
    np.testing.assert_allclose(golden_outputs(metric), metric.card["golden"], atol=1e-4)


def test_the_shipped_metric_tells_good_from_bad_grasps_of_a_can(scene):
    made = can_scene()
    for hints, least in ((scene[1], 0.9), (None, 0.75)):
        told = load_metric().predict(made.candidates, scene[0], hints)
        assert auc(told.success, made.label_rate > SUCCESS_RATE) > least


def test_the_shipped_card_tells_data_settings_and_figures():
    card = load_metric().card
    assert card["samples"] >= 200_000
    assert len(card["objects_learnt"]) >= 60
    assert card["hand"] == right_hand().description.name
    assert {"settings", "held_out", "rounds"} <= set(card)


def test_damaged_shipped_weights_are_named(tmp_path):
    path = tmp_path / "grasp_metric.safetensors"
    shutil.copy(shipped_weights(), path)
    shutil.copy(card_path(shipped_weights()), card_path(path))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))
    with pytest.raises(BadInput, match="SHA-256"):
        load_metric(path)
