import dataclasses as dc
import json

import numpy as np
import pytest
from learning_scenes import can_estimate, can_scene

from vh_drake.catalog import REPRODUCTIONS, Options
from vh_drake.errors import BadInput
from vh_drake.experiments import figure_4_7, figure_4_8, metric_scenes, table_4_5, ungraspable
from vh_drake.experiments.evaluate_command import evaluate
from vh_drake.experiments.metric_scenes import (
    TOUCH_COUNTS,
    evaluation_objects,
    evaluation_settings,
    judged_scenes,
)
from vh_drake.experiments.ungraspable import searched_poses
from vh_drake.learning.evaluating import METRICS, Judged, judge_scene, judged
from vh_drake.learning.shards import shard_bytes
from vh_drake.learning.training_objects import VALIDATION_KINDS

PNG = b"\x89PNG"


def drawn(name, index, count=60):
    """A judged scene whose learned scores are right and whose others are noise."""
    rng = np.random.default_rng(index)
    success = rng.random(count) < 0.5
    scores = {metric: rng.random(count) for metric in METRICS}
    scores["learned"] = np.where(success, 0.97, 0.1)
    return Judged(name, index, 1, index % 6, success, scores)


SCENES = [drawn(name, 6 * i + j) for i, name in enumerate(("box", "can")) for j in range(6)]
SETTINGS = {"split": "test"}


def test_the_figure_has_a_row_an_object_and_a_row_a_number_of_touches(tmp_path):
    report = figure_4_7.report(SCENES, SETTINGS, Options(out=tmp_path))
    assert [row["object"] for row in report.rows if "object" in row] == ["box", "can"]
    assert [row["touches"] for row in report.rows if "touches" in row] == list(range(6))
    assert all(row["split"] == "test" for row in report.rows if "object" in row)
    assert report.summary["learned_precision"] == 1.0
    assert report.summary["objects_not_worse_than_nominal"] == 2
    assert report.thesis["nominal_precision"] == 0.65
    assert (tmp_path / "figure-4.7.png").read_bytes().startswith(PNG)
    json.dumps(report.content(), allow_nan=False)


def failing(name, index):
    scene = drawn(name, index)
    return dc.replace(scene, success=np.zeros(len(scene.success), bool))


def test_poses_that_no_hand_can_grasp_bound_the_top1_success():
    lost, hard = ([failing("slab", 6 * i + j) for j in range(6)] for i in (2, 3))
    searched = [
        {"object": "slab", "scenes_alike": [12, 13, 15, 16, 17], "graspable": False},
        {"object": "slab", "scenes_alike": [14], "graspable": True},  # drawn anew
        {"object": "slab", "scenes_alike": [18, 19, 20, 21, 22, 23], "graspable": True},
    ]
    told = figure_4_7.possible([*SCENES, *lost, *hard], searched)
    assert told["scenes_without_any_grasp_on_truth"] == 5
    assert told["top1_ceiling"] == pytest.approx(19 / 24, abs=1e-4)
    assert told["top1_success_below_ceiling"] == pytest.approx(12 / 19, abs=1e-4)


def test_only_scenes_without_success_are_searched_and_once(tmp_path, monkeypatch):
    monkeypatch.setattr(metric_scenes, "VALIDATION_KINDS", frozenset({"screw_box"}))
    options = Options(scenes=3, workers=1, out=tmp_path)
    scenes, settings = judged_scenes(options, candidates=10, perturbations=8)
    assert searched_poses(scenes, options, settings) == []  # of a box that the hand spans
    some = [dc.replace(s, success=np.zeros_like(s.success)) for s in scenes[1:]]
    monkeypatch.setattr(ungraspable, "best_grasp", lambda *_: (0.9, 7))
    (row,) = searched_poses([scenes[0], *some], options, settings)
    assert row == {
        "object": "screw_box",
        "scenes_alike": [1, 2],
        "searched": 7,
        "best_rate_on_truth": 0.9,
        "graspable": True,
    }
    monkeypatch.setattr(ungraspable, "best_grasp", None)  # The journal knows the rest.
    assert searched_poses([scenes[0], *some], options, settings) == [row]


def test_poses_that_were_drawn_anew_are_searched_apart(tmp_path, monkeypatch):
    one, other = can_scene(0), dc.replace(can_scene(0), scene=1, view=can_estimate()[0])
    (tmp_path / "shard").write_bytes(shard_bytes([one, other]))
    monkeypatch.setattr(ungraspable, "true_object", lambda mesh, scene, settings: None)
    monkeypatch.setattr(ungraspable, "best_grasp", lambda *_: (0.1, 7))
    task = {"shard": str(tmp_path / "shard"), "scenes": [0, 1], "folder": None, "settings": [10, 8]}
    assert [row["scenes_alike"] for row in ungraspable.search_rows(task)] == [[0], [1]]


def test_the_same_scenes_give_the_same_bytes(tmp_path):
    pictures = []
    for name in ("a", "b"):
        figure_4_7.report(SCENES, SETTINGS, Options(out=tmp_path / name))
        pictures.append((tmp_path / name / "figure-4.7.png").read_bytes())
    assert pictures[0] == pictures[1]


def test_the_table_has_a_success_for_each_number_of_touches():
    report = table_4_5.report(SCENES, SETTINGS)
    for touches in TOUCH_COUNTS:
        assert report.summary[f"success_{touches}"] == 1.0
        assert report.thesis[f"success_{touches}"] >= 0.89
    assert [row["object"] for row in report.rows] == ["box", "can"]


def test_the_pictured_grasps_are_those_that_a_metric_selects():
    scene = can_scene()
    row = judged(judge_scene(scene, None), [1])
    picture = figure_4_8.draw(scene, row)
    assert picture.startswith(PNG)


def test_scenes_are_of_objects_that_no_metric_learns_from(tmp_path):
    assert evaluation_objects(Options(out=tmp_path)) == sorted(VALIDATION_KINDS)
    for name in ("one", "two", "three"):
        (tmp_path / f"{name}.obj").write_text("v 0 0 0\n")
    (tmp_path / "objects.csv").write_text("name,split\none,train\ntwo,test\nthree,test\n")
    assert evaluation_objects(Options(objects=tmp_path, out=tmp_path)) == ["three", "two"]
    assert evaluation_objects(Options(objects=tmp_path, split="train", out=tmp_path)) == ["one"]
    with pytest.raises(BadInput, match="no object of the split 'else'"):
        evaluation_objects(Options(objects=tmp_path, split="else", out=tmp_path))


def test_objects_are_taken_as_they_are_and_labels_from_many_disturbances():
    settings = evaluation_settings(800, 400)
    assert settings.label.min_samples == settings.label.max_samples == 400
    assert settings.scene.scale == settings.scene.stretch == [1.0, 1.0]
    assert settings.touch_counts == list(TOUCH_COUNTS)


def test_a_small_run_from_scenes_to_report_is_taken_up_again(tmp_path, monkeypatch):
    monkeypatch.setattr(metric_scenes, "VALIDATION_KINDS", frozenset({"screw_box"}))
    options = Options(scenes=2, workers=1, out=tmp_path)
    first, settings = judged_scenes(options, candidates=10, perturbations=8)
    files = {path: path.stat().st_mtime_ns for path in (tmp_path / "scenes").glob("*.parquet")}
    again, _ = judged_scenes(options, candidates=10, perturbations=8)
    assert {path: path.stat().st_mtime_ns for path in files} == files
    assert settings["scenes"] == 2
    assert [scene.touches for scene in first] == [0, 1]
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one.scores["learned"], other.scores["learned"])


def test_a_users_data_set_is_evaluated(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "scenes-00000.parquet").write_bytes(shard_bytes([can_scene()]))
    report = evaluate(tmp_path / "data", None, tmp_path / "out", workers=1)
    assert report.name == "evaluate"
    assert report.summary["scenes"] == 1
    assert (tmp_path / "out" / "evaluate.png").read_bytes().startswith(PNG)


def test_the_commands_are_in_the_catalogue():
    for name in ("figure-4.7", "figure-4.8", "table-4.5"):
        assert "weights" in REPRODUCTIONS[name].options
