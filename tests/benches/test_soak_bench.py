import numpy as np
import pytest

from vh_drake.benches import soak
from vh_drake.benches.soak import (
    digest,
    growth_mb,
    places_not_finite,
    resident_mb,
    run,
    soak_summary,
)
from vh_drake.catalog import Options


def test_numbers_that_are_not_finite_are_found_wherever_they_are():
    result = {"a": 1.0, "b": [0.0, {"c": float("nan")}], "d": {"e": (float("inf"), None, "nan")}}
    assert list(places_not_finite(result)) == ["/b/1/c", "/d/e/0"]


def test_memory_in_use_rises_with_what_is_kept():
    before = resident_mb()
    kept = np.ones(8 * 2**20)  # 64 MiB
    assert resident_mb() - before == pytest.approx(64, abs=8)
    assert kept.sum() > 0


def rows_of(process, memory, digests=None):
    return [
        {"process": process, "memory_mb": m, "crash": "", "not_finite": [], "digest": d}
        for m, d in zip(memory, digests or ["a"] * len(memory), strict=True)
    ]


def test_memory_counts_once_caches_are_full():
    memory = [100.0, 300.0, 350.0, 400.0, 400.0, 410.0, 415.0, 412.0, 411.0, 412.0, 413.0]
    assert growth_mb(memory) == 5.0
    assert growth_mb([100.0, 130.0, 131.0]) == 1.0


def test_the_process_that_grew_most_counts():
    rows = [*rows_of(1, [100.0, 300.0, 301.0, 300.0]), *rows_of(2, [90.0, 280.0, 283.0])]
    rows = [rows[i] for i in (0, 4, 1, 5, 2, 6, 3)]
    summary = soak_summary(rows, count=7)
    assert summary["memory_growth_mb"] == 3.0
    assert summary["most_trials_in_a_process"] == 4
    assert summary["largest_memory_mb"] == 301.0


def test_a_trial_that_comes_out_otherwise_when_repeated_is_told():
    rows = rows_of(1, [1.0] * 5, ["a", "b", "c", "a", "b"])
    assert soak_summary(rows, count=3)["same_again"]
    rows[-1]["digest"] = "c"
    assert not soak_summary(rows, count=3)["same_again"]


def test_results_that_differ_in_the_last_digit_have_other_digests():
    result = {"lifted": True, "slip_mm": [0.1, 0.2]}
    assert digest(result) == digest({"lifted": True, "slip_mm": [0.1, 0.2]})
    assert digest(result) != digest({"lifted": True, "slip_mm": [0.1, np.nextafter(0.2, 1)]})


def test_a_trial_that_crashes_is_counted_and_the_others_go_on(monkeypatch, tmp_path):
    calls = []

    def trial(scenario):
        calls.append((scenario.object, scenario.seed))
        if len(calls) == 2:
            raise RuntimeError("solver diverged")
        return type("Result", (), {"result": {"lifted": True, "slip_mm": float(len(calls) > 3)}})

    monkeypatch.setattr(soak, "run_trial", trial)
    summary = run(Options(runs=3, workers=1, out=tmp_path)).summary
    assert calls[:3] == calls[3:]
    assert summary["trials"] == 6
    assert summary["crashes"] == 1
    assert not summary["same_again"]  # The first told another slip.


@pytest.mark.slow
def test_whole_trials_in_a_row_leave_nothing_behind_and_repeat(tmp_path, monkeypatch):
    monkeypatch.setattr(soak, "library_names", lambda: ["fruit_drink"])
    monkeypatch.setattr(soak, "REPEATED", 1)
    summary = run(Options(runs=3, workers=1, out=tmp_path)).summary
    assert summary["crashes"] == 0
    assert summary["trials_with_non_finite_values"] == 0
    assert summary["memory_growth_mb"] < 60.0  # A diagram that stays takes 63 MB.
    assert summary["same_again"]
