import numpy as np
import pytest

from vh_drake.benches import soak
from vh_drake.benches.soak import places_not_finite, resident_mb, run, summarized
from vh_drake.catalog import Options


def test_numbers_that_are_not_finite_are_found_wherever_they_are():
    result = {"a": 1.0, "b": [0.0, {"c": float("nan")}], "d": {"e": (float("inf"), None, "nan")}}
    assert list(places_not_finite(result)) == ["/b/1/c", "/d/e/0"]


def test_memory_in_use_rises_with_what_is_kept():
    before = resident_mb()
    kept = np.ones(8 * 2**20)  # 64 MiB
    assert resident_mb() - before == pytest.approx(64, abs=8)
    assert kept.sum() > 0


def test_memory_counts_once_caches_are_full():
    memory = [100.0, 300.0, 350.0, 400.0, 400.0, 410.0, 415.0, 412.0, 411.0, 412.0, 413.0]
    rows = [{"memory_mb": m, "crash": "", "not_finite": []} for m in memory]
    summary = summarized(rows, same=True)
    assert summary["memory_growth_mb"] == 5.0
    assert summary["largest_memory_mb"] == 415.0
    assert (summary["crashes"], summary["trials_with_non_finite_values"]) == (0, 0)


def test_a_trial_that_crashes_is_counted_and_the_others_go_on(monkeypatch, tmp_path):
    calls = []

    def trial(scenario):
        calls.append(scenario.object)
        if len(calls) == 2:
            raise RuntimeError("solver diverged")
        return type("Result", (), {"result": {"lifted": True, "slip_mm": float(len(calls) > 2)}})

    monkeypatch.setattr(soak, "run_trial", trial)
    summary = run(Options(runs=3, out=tmp_path)).summary
    assert calls[0] == calls[-1]
    assert summary["trials"] == 4
    assert summary["crashes"] == 1
    assert not summary["same_again"]  # The first told another slip.


@pytest.mark.slow
def test_trials_in_a_row_leave_their_diagrams_behind_and_repeat(tmp_path, monkeypatch):
    monkeypatch.setattr(soak, "_WARM", 1)
    monkeypatch.setattr(soak, "library_names", lambda: ["fruit_drink"])
    summary = run(Options(runs=2, out=tmp_path)).summary
    assert summary["crashes"] == 0
    assert summary["trials_with_non_finite_values"] == 0
    # Drake frees no diagram with systems in Python, 63 MB each: a trial leaves no more than that.
    assert summary["memory_growth_mb"] < 80.0
    assert summary["same_again"]
