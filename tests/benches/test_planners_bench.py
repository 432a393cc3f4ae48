import pytest

from vh_drake.benches import planners
from vh_drake.benches.planners import run, summarized
from vh_drake.catalog import Options


@pytest.mark.slow
def test_every_candidate_of_the_bench_is_usable(monkeypatch, tmp_path):
    monkeypatch.setattr(planners, "CANDIDATES", 60)
    monkeypatch.setattr(planners, "REPEATS", 1)
    report = run(Options(out=tmp_path, runs=1))
    (row,) = report.rows
    assert row["candidates"] == row["surface_planner"] + row["skeleton_planner"] == 60
    assert report.summary["usable_share"] >= 0.95
    assert report.summary["seconds"] > 0


def test_the_summary_takes_the_worst_scene():
    good = {
        "candidates": 800,
        "seconds": 1.0,
        "usable_share": 1.0,
        "executable_share": 1.0,
        "nearest_mm": 5.0,
        "distinct": 40,
    }
    bad = good | {"candidates": 700, "seconds": 3.0, "usable_share": 0.9, "executable_share": 0.8}
    summary = summarized([good, bad])
    assert summary["candidates"] == 700
    assert summary["seconds"] == 3.0
    assert summary["usable_share"] == 0.9
    assert summary["executable_share"] == 0.8
    assert summary["seconds_median"] == 2.0
