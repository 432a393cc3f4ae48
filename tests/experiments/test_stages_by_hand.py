import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.experiments import stages_by_hand
from vh_drake.experiments.hand_scenes import drawn_scene, hand_task, model_of
from vh_drake.experiments.lift_trials import LiftObject
from vh_drake.experiments.stages import WHOLE
from vh_drake.experiments.stages_by_hand import VARIANTS, Variant, best_grasp, fully_known
from vh_drake.geometry.sampling import sample_surface
from vh_drake.geometry.signed_distance import distance_to_surface, interpolate
from vh_drake.grasping.planner_settings import PlannerSettings

TASK = hand_task(LiftObject("fruit_drink"), 1)


@pytest.fixture(scope="module")
def scenes():
    model = model_of("fruit_drink", "", None)
    return {touches: drawn_scene(model, "fruit_drink", 1, touches) for touches in (0, 1)}


def test_a_touch_changes_the_estimate_and_nothing_else(scenes):
    without, touched = scenes[0], scenes[1]
    np.testing.assert_array_equal(without.truth.X_WO, touched.truth.X_WO)
    np.testing.assert_array_equal(without.view.p_WO, touched.view.p_WO)
    assert len(without.contacts) == 0
    assert len(touched.contacts) == 1


def test_the_true_surface_is_that_of_the_mesh(scenes):
    known = fully_known(scenes[0])
    mesh = scenes[0].truth.mesh
    assert distance_to_surface(mesh, known.surface.vertices).mean() < 3e-4
    p, n = sample_surface(mesh, 500, seed=1)
    value, gradient = interpolate(known.surface.potential, p)
    assert np.abs(value).mean() < 3e-4
    assert np.median(np.einsum("ij,ij->i", gradient, n)) > 0.95
    np.testing.assert_array_equal(known.view.p_WO, scenes[0].view.p_WO)


def test_a_variant_takes_what_its_planner_and_scorer_say(scenes):
    settings = PlannerSettings(approaches=["collect"], candidates=30)
    grasp = best_grasp(scenes[1], Variant(scorer="conventional", planner=settings), 1)
    assert grasp is not None
    assert grasp[1] == "collect"
    narrow = PlannerSettings(collect_widest_m=0.001, approaches=["collect"], rounds=1)
    assert best_grasp(scenes[1], Variant(planner=narrow), 1) is None


def test_every_variant_meets_every_scene_and_pairs_are_compared(monkeypatch, tmp_path):
    def outcomes(task):
        own = {name: task[name] for name in ("object", "split", "kind", "seed")}
        odd = task["seed"] % 2 == 1
        return [
            {"variant": name, **own, "found": True, "lifted": odd or name != "no touch"}
            for name in VARIANTS
        ]

    monkeypatch.setattr(stages_by_hand, "lifts_of_scene", outcomes)
    report = stages_by_hand.run(Options(scenes=60, workers=1, out=tmp_path))
    assert len(report.rows) == len(VARIANTS) * 61
    assert report.summary["scenes"] == 60
    assert 0.2 < report.summary["gain over no touch"] < 0.8
    low, high = report.summary["gain over no touch interval"]
    assert 0 < low < high
    assert report.summary["gain over epsilon"] == 0.0


@pytest.mark.slow
def test_a_scene_has_one_row_a_variant(monkeypatch):
    few = PlannerSettings(candidates=20)
    chosen = {WHOLE: Variant(planner=few), "no touch": Variant(touches=0, planner=few)}
    monkeypatch.setattr(stages_by_hand, "VARIANTS", chosen)
    rows = stages_by_hand.lifts_of_scene(TASK)
    assert [row["variant"] for row in rows] == list(chosen)
    assert all(row["found"] for row in rows)
    assert any(row["lifted"] for row in rows)
