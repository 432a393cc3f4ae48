import numpy as np
import pytest

from vh_drake.benches import contact
from vh_drake.benches.contact import MASSES_KG, approach_row, draw_scene, summary_at
from vh_drake.catalog import Options


def test_scenes_stand_on_the_table_before_the_pad_which_meets_them():
    for seed in range(20):
        model, X_TO, pad_height_m = draw_scene(np.random.default_rng(seed))
        points = (X_TO @ model.mesh.vertices.T).T
        assert points[:, 2].min() == pytest.approx(0.0, abs=1e-9)
        assert points[:, 0].min() == pytest.approx(0.04, abs=1e-9)
        assert 0.02 < pad_height_m < points[:, 2].max()
        assert MASSES_KG[0] <= model.mass_kg <= MASSES_KG[1]


@pytest.mark.slow
def test_an_approach_is_felt_and_the_same_again_for_the_same_seed():
    task = {"speed_m_s": 0.05, "seed": 1000}
    row = approach_row(task)
    assert row["detected"]
    assert not row["false_alarm"]
    assert 0 < row["delay_ms"] < 60
    assert row["position_error_mm"] < 10
    assert row == approach_row(task)


def test_the_summary_counts_what_was_missed_and_what_was_invented():
    felt = {"delay_ms": 20.0, "force_at_detection_n": 1.0, "force_overshoot_n": 0.5}
    felt |= {"position_error_mm": 2.0, "normal_error_deg": 5.0, "displacement_mm": 0.1}
    rows = [
        {"speed_m_s": 0.05, "mass_kg": 0.5, "detected": True, "false_alarm": False} | felt,
        {"speed_m_s": 0.05, "mass_kg": 0.1, "detected": False, "false_alarm": True},
        {"speed_m_s": 0.10, "mass_kg": 0.5, "detected": False, "false_alarm": False},
    ]
    summary = summary_at(rows, 0.05, "")
    assert summary["detected_share"] == 0.5
    assert summary["detected_share_over_150_g"] == 1.0
    assert summary["false_alarms"] == 1
    assert summary["delay_ms"] == 20.0
    assert summary_at(rows, 0.10, "_x")["detected_share_x"] == 0.0


def test_a_second_call_goes_on_where_the_first_one_stopped(tmp_path, monkeypatch):
    called = []

    def approach(task):
        if len(called) == 4:
            raise KeyboardInterrupt
        called.append(task)
        return {**task, "mass_kg": 0.5, "detected": False, "false_alarm": False}

    monkeypatch.setattr(contact, "approach_row", approach)
    options = Options(runs=2, workers=1, out=tmp_path)
    with pytest.raises(KeyboardInterrupt):
        contact.run(options)
    first, called = called, []
    report = contact.run(options)
    assert len(first) == 4
    assert len(called) == 2
    assert len(report.rows) == 6
