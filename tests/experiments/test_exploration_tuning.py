import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.experiments import exploration_tuning as tuning
from vh_drake.exploration.choosing import DEPARTURES
from vh_drake.objects import lathe


def made_row(strategy, setting, cost, reached):
    return {"strategy": strategy, "setting": setting, "cost_cm": cost, "reached_share": reached}


def test_every_strategy_is_tried_with_the_same_margins_and_departures():
    grid = tuning.settings_grid()
    for name, own in tuning.OWN.items():
        tried = [s for key, s in grid.items() if key.startswith(f"{name}:")]
        assert len(tried) == len(own) * len(tuning.MARGINS_M) * len(DEPARTURES)
        pairs = {(s.margin_m, s.departure) for s in tried}
        assert pairs == {(m, d) for m in tuning.MARGINS_M for d in DEPARTURES}


def test_the_cheapest_setting_wins_among_those_that_reach_the_goal(monkeypatch):
    monkeypatch.setattr(tuning, "OWN", {"a": [], "b": []})
    rows = [
        made_row("a", "cheap and stuck", 50.0, 0.8),
        made_row("a", "dear", 90.0, 1.0),
        made_row("a", "good", 80.0, 0.96),
        made_row("b", "never", 10.0, 0.5),
        made_row("b", "more often", 70.0, 0.9),
        made_row("b", "nearly as often", 60.0, 0.86),
        made_row("b", "cheaper and more seldom", 50.0, 0.84),
    ]
    summary = tuning.winners(rows)
    assert summary["a_setting"] == "good"
    assert (summary["b_setting"], summary["b_cost_cm"]) == ("nearly as often", 60.0)


def test_costs_are_geometric_means_over_objects_and_unfinished_runs_are_charged():
    costs = [
        {"object": "x", "cost_cm": 10.0, "reached": True},
        {"object": "x", "cost_cm": 30.0, "reached": False},
        {"object": "y", "cost_cm": 80.0, "reached": True},
    ]
    row = tuning.grid_row("igef: mu", costs)
    assert row["cost_cm"] == pytest.approx(np.sqrt(20.0 * 80.0), abs=1e-3)
    assert (row["strategy"], row["setting"]) == ("igef", "mu")
    assert row["reached_share"] == pytest.approx(2 / 3, abs=1e-4)


def test_the_grid_runs_on_a_folder_and_takes_its_train_split(tmp_path, monkeypatch):
    folder = tmp_path / "objects"
    folder.mkdir()
    for name in ("one", "two"):
        lathe.sphere(0.027).to_trimesh().export(folder / f"{name}.ply")
    (folder / "objects.csv").write_text("name,split\none,train\ntwo,test\n")
    monkeypatch.setattr(tuning, "OWN", {"igef": tuning.OWN["igef"][:1]})
    monkeypatch.setattr(tuning, "MARGINS_M", (0.03,))
    report = tuning.run(Options(objects=folder, runs=1, workers=1, out=tmp_path / "out"))
    assert report.settings["objects"] == ["one"]
    assert len(report.rows) == len(DEPARTURES)
    assert report.summary["igef_cost_cm"] == min(row["cost_cm"] for row in report.rows)
