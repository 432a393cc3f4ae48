import dataclasses as dc

import numpy as np
import pytest
from scipy.stats import binomtest

from vh_drake.catalog import Options
from vh_drake.errors import BadInput
from vh_drake.experiments import lift, lift_trials, robustness, table_4_6
from vh_drake.experiments.lift_trials import (
    LiftObject,
    chosen_objects,
    lift_row,
    make_scenario,
    trial_settings,
    wilson_interval,
)
from vh_drake.geometry.mesh_files import SUFFIXES
from vh_drake.objects.library import library_names, library_object
from vh_drake.scenes.scenario import Scenario


@pytest.fixture
def folder(tmp_path):
    """Four objects with a table."""
    rows = ["name,split,lift,mass_kg"]
    for name, split, kind in (
        ("a", "test", "core"),
        ("b", "test", "hard"),
        ("c", "test", "no"),
        ("d", "train", "core"),
    ):
        (tmp_path / f"{name}{SUFFIXES[0]}").write_text("")
        rows.append(f"{name},{split},{kind},0.3")
    (tmp_path / "objects.csv").write_text("\n".join(rows))
    return tmp_path


def test_the_test_split_is_taken_and_what_is_left_out_is_named(folder, tmp_path):
    chosen, left_out = chosen_objects(Options(objects=folder, out=tmp_path))
    assert [(item.name, item.kind, item.mass_kg) for item in chosen] == [
        ("a", "core", 0.3),
        ("b", "hard", 0.3),
    ]
    assert list(left_out) == ["c"]
    train, _ = chosen_objects(Options(objects=folder, split="train", out=tmp_path))
    assert [item.name for item in train] == ["d"]
    with pytest.raises(BadInput, match="no object of split 'validation'"):
        chosen_objects(Options(objects=folder, split="validation", out=tmp_path))


def test_without_a_folder_the_library_is_lifted(tmp_path):
    chosen, left_out = chosen_objects(Options(out=tmp_path))
    assert [item.name for item in chosen] == library_names()
    assert left_out == {}


def test_changes_reach_nested_settings_and_leave_the_rest():
    item = LiftObject("can", mass_kg=0.2)
    changes = {"attempts": 1, "camera": {"noise": {"axial_m": 0.005}}, "friction": 0.4}
    scenario = make_scenario(trial_settings(item, 7, "point", **changes)["scenario"])
    assert (scenario.object, scenario.mass_kg, scenario.seed) == ("can", 0.2, 7)
    assert (scenario.attempts, scenario.friction) == (1, 0.4)
    assert scenario.camera.noise.axial_m == 0.005
    expected = dc.replace(Scenario().camera.noise, axial_m=0.005)
    assert scenario.camera.noise == expected
    assert Scenario().camera.noise.axial_m != 0.005


def test_a_trial_that_can_not_run_is_a_failed_one_with_its_reason():
    row = lift_row(trial_settings(LiftObject("mugg"), 0, "point"))
    assert row["lifted"] is False
    assert "mugg" in row["failure"]


@pytest.mark.parametrize(("successes", "trials"), [(0, 10), (3, 10), (10, 10), (88, 100)])
def test_the_interval_is_that_of_wilson(successes, trials):
    expected = binomtest(successes, trials).proportion_ci(method="wilson")
    np.testing.assert_allclose(
        wilson_interval(successes, trials), [expected.low, expected.high], atol=2e-4
    )


def row(name, lifted, attempts, kind="core"):
    return lift_trials._NOTHING | {
        "object": name,
        "kind": kind,
        "lifted": lifted,
        "lifted_first": lifted and attempts == 1,
        "slip_mm": 1.0 if lifted else None,
        "attempts": attempts,
    }


def test_success_is_counted_at_the_first_attempt_and_in_all():
    rows = [row("a", True, 1), row("a", True, 2), row("b", False, 3, "hard"), row("b", True, 1)]
    summary = lift.lift_summary(rows)
    assert summary["first_attempt_success"] == 0.5
    assert summary["overall_success"] == 0.75
    assert summary["core_overall_success"] == 1.0
    assert summary["hard_trials"] == 1
    assert summary["trials"] == 4


def test_table_4_6_counts_a_failed_pose_as_the_limit(monkeypatch, tmp_path):
    def outcomes(tasks, *_):
        return [
            row(task["scenario"]["object"], task["scenario"]["object"] != "pliers", 2)
            for task in tasks.values()
        ]

    monkeypatch.setattr(table_4_6, "run_trials", outcomes)
    report = table_4_6.run(Options(runs=2, out=tmp_path))
    assert report.summary["objects"] == 8
    assert report.summary["lifted"] == 7
    assert report.summary["mean_attempts"] == pytest.approx((7 * 2 + 3) / 8, abs=1e-3)
    assert report.thesis["mean_attempts"] == pytest.approx(13 / 8)
    for name, mass in table_4_6.MASSES_KG.items():
        assert library_object(name).mass_kg > 0
        assert mass > 0


def test_every_condition_sees_the_same_scenes(monkeypatch, tmp_path):
    seen = {}

    def outcomes(tasks, *_):
        seen.update(tasks)
        return [row("a", "friction 0.4" not in key, 1) for key in tasks]

    monkeypatch.setattr(robustness, "run_trials", outcomes)
    summary = robustness.run(Options(scenes=3, out=tmp_path)).summary
    by_condition = {}
    for key, task in seen.items():
        make_scenario(task["scenario"])  # is in range
        by_condition.setdefault(key.split(": ")[0], []).append(key.split(": ")[1])
    assert len(by_condition) == len(robustness.conditions())
    assert len({tuple(keys) for keys in by_condition.values()}) == 1
    assert summary[robustness.BASE] == 1.0
    assert summary["friction 0.4"] == 0.0
    assert summary["largest_loss_points"] == 100.0
