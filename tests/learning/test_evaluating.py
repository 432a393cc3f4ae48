import dataclasses as dc

import numpy as np
import pytest
from learning_scenes import can_scene
from sklearn.metrics import precision_score

from vh_drake.learning.calibration import Calibration
from vh_drake.learning.evaluating import (
    METRICS,
    Judged,
    group_rows,
    judge_dataset,
    judge_scene,
    judged,
    mean_precision,
    pooled,
    precision_at,
    summarize,
    top1,
)
from vh_drake.learning.metric import GraspMetric, save_metric
from vh_drake.learning.network import GraspNetwork
from vh_drake.learning.shards import shard_bytes


def drawn(name, seed, count=200):
    """A scene whose learned scores are calibrated and whose other scores are noise."""
    rng = np.random.default_rng(seed)
    probability = rng.beta(0.5, 0.5, count)
    success = rng.random(count) < probability
    noise = {metric: rng.random(count).round(2) for metric in METRICS}
    noise["nominal"] = (rng.random(count) < 0.6).astype(float)
    return Judged(name, seed, 1, seed % 6, success, {**noise, "learned": probability})


@pytest.fixture(scope="module")
def scenes():
    return [drawn(name, 10 * i + j) for i, name in enumerate("abcd") for j in range(6)]


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    path = tmp_path_factory.mktemp("weights") / "m.safetensors"
    save_metric(path, GraspMetric(GraspNetwork().eval(), Calibration(), Calibration(), {}))
    return path


def test_precision_is_that_of_scikit_learn(scenes):
    own = [scene for scene in scenes if scene.object == "a"]
    every = pooled(own)
    expected = precision_score(every.success, every.selected("learned"))
    assert mean_precision(own, "learned") == pytest.approx(expected)


def test_scenes_without_a_grasp_that_succeeds_bound_the_best_choice(scenes):
    hopeless = dc.replace(scenes[0], success=np.zeros(200, bool))
    assert summarize(scenes)["top1_possible"] == 1.0
    summary = summarize([hopeless, *scenes[1:4]])
    assert summary["top1_possible"] == 0.75
    assert summary["top1_success"] <= 0.75


def test_a_metric_that_selects_nothing_has_no_precision(scenes):
    none = dc.replace(scenes[0], scores={**scenes[0].scores, "learned": np.zeros(200)})
    assert mean_precision([none], "learned") is None
    assert mean_precision([none, scenes[6]], "learned") == mean_precision([scenes[6]], "learned")


def test_at_the_whole_share_every_metric_has_the_share_of_successes(scenes):
    every = pooled(scenes)
    for name in METRICS:
        assert precision_at(every, name, 1.0) == pytest.approx(every.success.mean())
    assert precision_at(every, "learned", 0.0) is None


def test_ties_count_by_their_mean():
    success = np.array([True, False, True, False])
    scores = {name: np.array([1.0, 0.5, 0.5, 0.1]) for name in METRICS}
    scene = Judged("a", 0, 0, 0, success, scores)
    assert precision_at(scene, "rate", 0.5) == pytest.approx((1 + 0.5) / 2)
    tied = dc.replace(scene, scores={name: np.ones(4) for name in METRICS})
    assert top1([tied], "rate") == 0.5
    assert top1([scene], "rate") == 1.0
    assert top1([], "rate") is None


def test_the_summary_of_a_calibrated_metric_says_so(scenes):
    summary = summarize(scenes)
    assert summary["learned_precision"] > 0.93
    assert summary["calibration_error"] < 0.05
    assert summary["scenes_selecting_share"] == 1.0
    assert summary["failure_ratio"] == pytest.approx(
        (1 - summary["nominal_precision"]) / (1 - summary["learned_precision"]), rel=0.01
    )
    low, high = summary["learned_precision_interval"]
    assert low <= summary["learned_precision"] <= high
    assert summary["gain_over_rate_at_equal_share"] > 0.2
    assert summarize(scenes) == summary


def test_rows_cover_all_groups(scenes):
    rows = group_rows(scenes, "touches", lambda scene: scene.touches)
    assert [row["touches"] for row in rows] == [0, 1, 2, 3, 4, 5]
    assert sum(row["candidates"] for row in rows) == 24 * 200


def test_all_metrics_rate_every_candidate_of_a_labelled_scene(weights):
    row = judge_scene(can_scene(), weights)
    scene = judged(row, [0, 1])
    assert scene.touches == 0
    assert set(scene.scores) == set(METRICS)
    assert all(len(values) == len(can_scene().candidates) for values in scene.scores.values())
    np.testing.assert_array_equal(scene.success, can_scene().label_rate > 0.8)
    np.testing.assert_allclose(scene.scores["rate"], can_scene().estimate_rate, atol=1e-4)


def test_a_data_set_is_judged_once_and_taken_up_again(weights, tmp_path):
    (tmp_path / "scenes-00000.parquet").write_bytes(shard_bytes([can_scene()]))
    journal = tmp_path / "journal.jsonl"
    first = judge_dataset(tmp_path, weights, journal=journal, workers=1)
    before = journal.read_bytes()
    again = judge_dataset(tmp_path, weights, journal=journal, workers=1)
    assert journal.read_bytes() == before
    for name in METRICS:
        np.testing.assert_array_equal(first[0].scores[name], again[0].scores[name])
