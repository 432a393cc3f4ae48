import numpy as np
import pytest
from scipy.stats import bootstrap

from vh_drake.catalog import Options
from vh_drake.experiments import closed_loop, hand_eye, stages
from vh_drake.experiments.lift_trials import make_scenario
from vh_drake.experiments.stages import VARIANTS, WHOLE, paired_interval


def outcome(key):
    """Without a touch every second scene fails; nothing else matters."""
    variant, scene = key.split(": ")
    lifted = variant != "no touch" or int(scene.split()[-1]) % 2 == 0
    return {"object": scene.split()[0], "lifted": lifted}


def test_every_variant_meets_the_same_scenes_and_its_loss_is_counted(monkeypatch, tmp_path):
    seen = {}

    def outcomes(tasks, *_):
        seen.update(tasks)
        return [outcome(key) for key in tasks]

    monkeypatch.setattr(stages, "run_trials", outcomes)
    report = stages.run(Options(scenes=60, out=tmp_path))
    by_variant = {}
    for key, task in seen.items():
        scenario = make_scenario(task["scenario"])  # is in range
        assert scenario.attempts == 1
        by_variant.setdefault(key.split(": ")[0], []).append(key.split(": ")[1])
    assert list(by_variant) == list(VARIANTS)
    assert len({tuple(scenes) for scenes in by_variant.values()}) == 1
    assert report.summary["success"] == 1.0
    odd = sum(int(scene.split()[-1]) % 2 for scene in by_variant[WHOLE])
    assert report.summary["gain over no touch"] == pytest.approx(odd / 60, abs=1e-4)
    low, high = report.summary["gain over no touch interval"]
    assert 0 < low < odd / 60 < high
    assert report.summary["gain over epsilon"] == 0.0
    low, high = report.summary["gain over epsilon interval"]
    assert low < 0 < high


def test_variants_change_what_they_name():
    changed = {name: make_scenario(dict(changes)) for name, changes in VARIANTS.items()}
    assert changed["no touch"].touches == 0
    assert changed["nominal force closure"].scorer == "nominal"
    assert changed["skeleton planner only"].planners == ["skeleton"]
    assert changed["top grasps only"].approaches == ["collect"]
    assert "side" in changed[WHOLE].approaches


def test_the_interval_is_that_of_the_percentile_bootstrap():
    rng = np.random.default_rng(5)
    a, b = (rng.random((2, 80)) < [[0.9], [0.7]]).astype(float)
    expected = bootstrap(
        (a - b,), np.mean, method="percentile", n_resamples=10_000, rng=1
    ).confidence_interval
    np.testing.assert_allclose(paired_interval(a, b, 0), expected, atol=0.01)


def test_closed_and_open_loop_meet_the_same_scenes(monkeypatch, tmp_path):
    modes = {}

    def outcomes(tasks, *_):
        for key, task in tasks.items():
            modes.setdefault(make_scenario(task["scenario"]).closing, []).append(key.split(": ")[1])
        return [{"object": key, "lifted": "closed" in key} for key in tasks]

    monkeypatch.setattr(stages, "run_trials", outcomes)
    summary = closed_loop.run(Options(scenes=30, out=tmp_path)).summary
    assert modes["closed_loop"] == modes["open_loop"]
    assert summary["success"] == summary["gain over open loop"] == 1.0


def test_touches_meet_the_same_badly_calibrated_cameras(monkeypatch, tmp_path):
    seen = {}

    def outcomes(tasks, *_):
        seen.update(tasks)
        return [{"object": key, "lifted": "one touch" in key or "10 mm" in key} for key in tasks]

    monkeypatch.setattr(stages, "run_trials", outcomes)
    summary = hand_eye.run(Options(scenes=30, out=tmp_path)).summary
    cameras, scenes = {}, {}
    for key, task in seen.items():
        scenario = make_scenario(task["scenario"])
        variant, scene = key.split(": ")
        assert scenario.touches == ("one" in variant)
        scenes.setdefault(variant, []).append(scene)
        cameras.setdefault(variant.split(", ", 1)[1], set()).add(
            scenario.camera.calibration_shift_m
        )
    assert len({tuple(each) for each in scenes.values()}) == 1
    assert list(cameras.values()) == [{0.01}, {0.02}]
    assert summary["scenes"] == 30
    worse, better = reversed(list(cameras))
    assert summary[f"one touch, {worse}"] == summary[f"gain over no touch, {worse}"] == 1.0
    assert summary[f"gain over no touch, {better}"] == 0.0
