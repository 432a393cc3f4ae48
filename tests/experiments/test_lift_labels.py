import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.experiments import labels
from vh_drake.experiments.labels import SCORES, drawn_by_lot, summarized
from vh_drake.learning.calibration import auc


def rows(count=200, seed=0):
    """Lifts of two objects that the true rate foretells, the metric a little, epsilon not."""
    rng = np.random.default_rng(seed)
    made = []
    for i in range(count):
        rate = rng.random()
        row = {name: float(rng.random()) for name in SCORES}
        row |= {"rate": rate, "learned": 0.5 * (rate + rng.random())}
        place = {"object": "ab"[i % 2], "split": "test", "kind": "core", "seed": i // 20}
        made.append({**place, **row, "lifted": bool(rng.random() < rate)})
    return made


def test_all_candidates_are_drawn_equally_often():
    drawn = np.array([drawn_by_lot(50, 20, seed) for seed in range(500)])
    assert all(len(set(chosen)) == 20 for chosen in drawn)
    times = np.bincount(drawn.ravel(), minlength=50)
    assert abs(times - 200).max() < 5 * np.sqrt(200 * 0.6)
    assert drawn_by_lot(5, 20, 0).tolist() == [0, 1, 2, 3, 4]
    np.testing.assert_array_equal(drawn_by_lot(50, 20, 7), drawn[7])


def test_a_calibrated_score_that_is_spread_evenly_has_an_area_of_five_sixths():
    rng = np.random.default_rng(0)
    score = rng.random(100_000)
    assert auc(score, rng.random(100_000) < score) == pytest.approx(5 / 6, abs=0.005)


def test_areas_tell_what_foretells_a_lift():
    summary = summarized(rows(), 0)
    assert summary["lifts"] == 200
    assert summary["auc_rate"] > summary["auc_learned"] > 0.6
    assert summary["auc_epsilon"] == pytest.approx(0.5, abs=0.1)
    low, high = summary["auc_rate_interval"]
    assert low <= summary["auc_rate"] <= high
    assert summary["calibration_error_rate"] < 0.15
    assert summarized([], 0)["lifts"] == 0


def test_a_run_lifts_every_scene_and_draws_its_curves(monkeypatch, tmp_path):
    seen = []

    def lifts(task):
        seen.append((task["object"], task["seed"]))
        return [{**row, "object": task["object"]} for row in rows(20, len(seen))]

    monkeypatch.setattr(labels, "lifts_of_scene", lifts)
    report = labels.run(Options(scenes=4, workers=1, out=tmp_path))
    assert len(set(seen)) == 4
    assert report.summary["lifts"] == 80
    assert (tmp_path / "labels.png").stat().st_size > 10_000
    objects = [row for row in report.rows if "lifted_share" in row]
    assert [row["object"] for row in objects] == sorted({name for name, _ in seen})
    assert sum(row["lifts"] for row in objects) == 80


@pytest.mark.slow
def test_a_scene_s_grasps_are_rated_and_lifted(monkeypatch):
    monkeypatch.setattr(labels, "GRASPS", 3)
    task = {"object": "fruit_drink", "folder": "", "mass_kg": None, "weights": None}
    found = labels.lifts_of_scene({**task, "split": "embedded", "kind": "core", "seed": 1})
    assert len(found) == 3
    for row in found:
        assert all(0.0 <= row[name] <= 1.0 for name in SCORES if "epsilon" not in name)
        assert isinstance(row["lifted"], bool)
    assert found[0]["learned"] <= found[-1]["learned"]
