import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from scenery import right_hand

from vh_drake.benches import contact
from vh_drake.benches.contact import (
    MASSES_KG,
    Patch,
    Watch,
    approach_row,
    draw_scene,
    summary_at,
    true_patches,
)
from vh_drake.catalog import Options
from vh_drake.objects.lathe import box
from vh_drake.objects.model import make_object
from vh_drake.objects.primitives import BoxShape
from vh_drake.scenes.sliding_hand import WAIT_S, make_sliding_hand
from vh_drake.types import ContactSet


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


def patch(force_n, y_m=0.0, n=(-1.0, 0.0, 0.0)):
    return Patch(np.array([-force_n, 0.0, 0.0]), np.array([0.04, y_m, 0.9]), np.array(n))


def test_the_moment_of_the_greatest_force_tells_what_was_true():
    watch = Watch()
    for now, patches in ((0.1, []), (0.2, [patch(1.0)]), (0.3, [patch(0.01, 0.05)]), (0.4, [])):
        watch.note(patches, now)
    felt = ContactSet(np.array([[0.04, 0.003, 0.9]]), np.array([[-0.8, 0.6, 0.0]]))
    watch.compare(felt)
    assert watch.touched_s == 0.2
    assert watch.most_force_n == pytest.approx(1.0)
    assert watch.position_error_m == pytest.approx(0.003)
    assert watch.normal_error_rad == pytest.approx(np.arccos(0.8))


def test_of_two_fingers_that_press_the_nearer_one_counts_if_it_bears_a_part():
    felt = ContactSet(np.array([[0.04, 0.022, 0.9]]), np.array([[-1.0, 0.0, 0.0]]))
    for second_n, gap_m in ((0.6, 0.002), (0.1, 0.022)):
        watch = Watch()
        watch.note([patch(1.0), patch(second_n, 0.024)], 0.2)
        watch.compare(felt)
        assert watch.most_force_n == pytest.approx(1.0 + second_n)
        assert watch.position_error_m == pytest.approx(gap_m)


@pytest.mark.slow
def test_true_patches_of_a_brick_lie_on_its_face_and_push_the_hand_back():
    size = (0.06, 0.1, 0.08)
    brick = make_object("brick", box(size), 2.0, primitive=BoxShape(size, (0, 0, size[2] / 2)))
    X_TO = RigidTransform([0.04 + size[0] / 2, 0.0, 0.0])
    scene = make_sliding_hand(right_hand(), brick, X_TO, pad_height_m=0.05, speed_m_s=0.05, seed=1)
    simulator = Simulator(scene.diagram)
    plant_context = scene.plant.GetMyContextFromRoot(simulator.get_context())
    assert true_patches(scene, plant_context) == []
    simulator.AdvanceTo(WAIT_S + 0.04 / 0.05 + 0.05)
    found = true_patches(scene, plant_context)
    assert found
    for one in found:
        assert one.p_WC[0] == pytest.approx(0.04, abs=5e-4)
        np.testing.assert_allclose(one.n_WC, [-1.0, 0.0, 0.0], atol=1e-3)
        assert one.force_W[0] < -0.1


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
