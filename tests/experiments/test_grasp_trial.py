import csv
import dataclasses as dc
import itertools
import json

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from vh_drake.errors import NoGraspTried
from vh_drake.experiments.grasp_trial import (
    HELD_S,
    LIFTED_M,
    load_trial_object,
    make_trial,
    raise_failure,
    run_trial,
)
from vh_drake.experiments.judge import Judge
from vh_drake.experiments.lift_trials import make_scenario
from vh_drake.geometry.signed_distance import distance_to_surface
from vh_drake.grasping import approach
from vh_drake.scenes.placing import draw_object_pose
from vh_drake.scenes.scenario import POINT_STEP_S, Placement, Scenario

SCENARIO = Scenario(contact="point", time_step_s=0.004, seed=0, object="fruit_drink")
RESULT_KEYS = {
    "object",
    "mass_kg",
    "mass_source",
    "object_report",
    "seed",
    "scorer",
    "contact_model",
    "object_pose",
    "points_seen",
    "touches",
    "surface_error_before_touch_mm",
    "surface_error_mm",
    "candidates",
    "attempts",
    "grasp",
    "lifted",
    "height_m",
    "hold_s",
    "slip_mm",
    "slip_deg",
    "failure",
}
TOUCH_KEYS = {
    "felt",
    "time_s",
    "predicted_position_m",
    "predicted_normal",
    "rating",
    "object_displacement_mm",
    "felt_position_m",
    "felt_normal",
    "actual_position_m",
    "actual_normal",
    "prediction_error_mm",
    "prediction_normal_error_deg",
    "cosine_to_camera",
    "faces_away_from_camera",
    "felt_error_mm",
    "felt_normal_error_deg",
    "view_shift_m",
}
GRASP_KEYS = {
    "X_WH",
    "motion",
    "planner",
    "score",
    "unreachable_better_ones",
    "robot_feels_it_held",
    "felt_weight_n",
}


@dc.dataclass
class Ran:
    """A whole trial: its files, and the phases that it went through."""

    result: dict
    timing: dict
    phases: list
    files: set
    signals: list


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trial")
    out, log, phases = folder / "out", folder / "signals.csv", []
    done = run_trial(SCENARIO, out=out, on_phase=lambda *phase: phases.append(phase), log=log)
    result, timing = (
        json.loads((out / name).read_text()) for name in ("result.json", "timing.json")
    )
    assert (done.result, done.timing, done.warnings) == (result, timing, ())
    signals = list(csv.DictReader(log.read_text().splitlines()))
    return Ran(result, timing, phases, {path.name for path in out.iterdir()}, signals)


@pytest.mark.slow
def test_the_log_holds_the_signals_of_the_whole_run(ran):
    time_s = np.array([float(row["time_s"]) for row in ran.signals])
    np.testing.assert_allclose(np.diff(time_s), 0.01, atol=1e-6)
    assert time_s[-1] == pytest.approx(ran.timing["simulated_s"], abs=1e-3)
    held = [row for row in ran.signals if row["phase"] == "grasp: hold"][50:]
    weight = 9.81 * ran.result["mass_kg"]
    assert np.mean([float(row["wrist_force_z_n"]) for row in ran.signals]) != 0
    rose = float(held[-1]["p_WH_z_m"]) - min(float(row["p_WH_z_m"]) for row in ran.signals)
    assert rose > LIFTED_M
    tendon = np.mean([float(row["tendon_force_1_n"]) for row in held])
    assert tendon > weight  # What holds it by friction pulls harder than it weighs.
    assert {"joint_8_rad_per_s", "motor_2", "motor_command_2", "q_WH_w"} <= set(held[0])


@pytest.mark.slow
def test_result_json_holds_the_documented_keys_and_the_scenario_s_values(ran):
    assert ran.files == {"result.json", "timing.json"}
    assert set(ran.result) == RESULT_KEYS
    assert [set(touch) for touch in ran.result["touches"]] == [TOUCH_KEYS]
    assert set(ran.result["grasp"]) == GRASP_KEYS
    for key, value in {
        "object": "fruit_drink",
        "seed": 0,
        "scorer": "learned",
        "contact_model": "point",
    }.items():
        assert ran.result[key] == value
    pose = draw_object_pose(SCENARIO, load_trial_object(SCENARIO)).GetAsMatrix4()
    np.testing.assert_allclose(np.reshape(ran.result["object_pose"], (4, 4)), pose, atol=1e-5)


@pytest.mark.slow
def test_the_finger_felt_a_place_that_the_camera_can_not_see(ran):
    (touch,) = ran.result["touches"]
    assert touch["felt"]
    assert touch["faces_away_from_camera"]
    assert touch["cosine_to_camera"] < 0.0
    assert touch["object_displacement_mm"] < 5.0
    assert touch["prediction_error_mm"] < 20.0
    assert touch["felt_error_mm"] < 5.0


@pytest.mark.slow
def test_the_errors_are_those_of_the_reported_places(ran):
    (touch,) = ran.result["touches"]
    actual, normal = np.array(touch["actual_position_m"]), np.array(touch["actual_normal"])
    for name, kind in (("predicted", "prediction"), ("felt", "felt")):
        apart = 1000.0 * np.linalg.norm(np.array(touch[f"{name}_position_m"]) - actual)
        angle = np.rad2deg(np.arccos(normal @ touch[f"{name}_normal"]))
        assert touch[f"{kind}_error_mm"] == pytest.approx(apart, abs=0.05)
        assert touch[f"{kind}_normal_error_deg"] == pytest.approx(angle, abs=0.1)


@pytest.mark.slow
def test_the_actual_touch_lies_on_the_object_where_it_was_placed(ran):
    (touch,) = ran.result["touches"]
    X_WO = np.reshape(ran.result["object_pose"], (4, 4))
    mesh = load_trial_object(SCENARIO).mesh.transformed(X_WO)
    gap = distance_to_surface(mesh, np.array([touch["actual_position_m"]]))[0]
    assert gap < 0.002 + 0.001 * touch["object_displacement_mm"]


@pytest.mark.slow
def test_the_surface_was_estimated_to_millimetres_and_a_candidate_of_it_was_tried(ran):
    for key in ("surface_error_before_touch_mm", "surface_error_mm"):
        assert 0.0 < ran.result[key] < 5.0
    grasp = ran.result["grasp"]
    assert ran.result["candidates"][grasp["planner"]] > grasp["unreachable_better_ones"] >= 0
    assert 0.0 < grasp["score"] <= 1.0
    R = np.reshape(grasp["X_WH"], (4, 4))[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-4)


@pytest.mark.slow
def test_the_object_was_lifted_and_held(ran):
    assert ran.result["lifted"]
    assert ran.result["failure"] == ""
    assert ran.result["height_m"] >= LIFTED_M
    assert ran.result["hold_s"] >= HELD_S
    assert 0.0 <= ran.result["slip_mm"] < 20.0
    assert 0.0 <= ran.result["slip_deg"] < 20.0
    raise_failure(ran.result)  # says nothing


@pytest.mark.slow
def test_timing_json_adds_up(ran):
    timing = ran.timing
    seconds = {"wall_s", "processor_s", "simulated_s"}
    assert set(timing) == seconds | {"real_time_factor", "real_time_factor_processor", "stages"}
    stages = timing["stages"]
    assert list(stages) == [
        "build",
        "look",
        "estimate",
        "plan a touch",
        "touch",
        "retreat",
        "plan grasps",
        "grasp",
    ]
    simulated = sum(stage["simulated_s"] for stage in stages.values())
    assert simulated == pytest.approx(timing["simulated_s"], abs=0.01)
    assert 0.0 < sum(stage["wall_s"] for stage in stages.values()) <= timing["wall_s"]
    assert timing["real_time_factor"] >= timing["simulated_s"] / timing["wall_s"]


@pytest.mark.slow
def test_a_phase_is_told_when_it_changes_and_in_the_order_of_time(ran):
    names, times = zip(*ran.phases, strict=True)
    assert list(times) == sorted(times)
    assert all(a != b for a, b in itertools.pairwise(names))
    assert names.index("plan a touch") < names.index("touch: feel") < names.index("plan grasps")
    assert "grasp: hold" in names


@pytest.mark.parametrize("center", [[1.05, 0.1], [0.7, 0.6]])
def test_an_object_out_of_the_workspace_or_of_the_view_is_a_failure_without_a_grasp(
    center, tmp_path
):
    scenario = dc.replace(SCENARIO, placement=Placement(center, 0.0))
    done = run_trial(scenario, out=tmp_path)
    result = json.loads((tmp_path / "result.json").read_text())
    assert set(result) == RESULT_KEYS
    assert result["grasp"] is None
    assert result["touches"] == []
    assert not done.lifted
    assert done.timing["simulated_s"] < 5.0
    with pytest.raises(NoGraspTried, match="table") as error:
        raise_failure(result)
    assert str(error.value) == result["failure"]
    p_WO = RigidTransform(np.reshape(result["object_pose"], (4, 4))).translation()
    np.testing.assert_allclose(p_WO[:2], center, atol=0.1)


def test_a_trial_without_any_grasp_is_an_error_that_says_why():
    with pytest.raises(NoGraspTried, match="none of 12"):
        raise_failure({"grasp": None, "failure": "the arm can reach none of 12 planned grasps"})


def test_a_grasp_that_was_tried_and_failed_is_a_result_not_an_error():
    raise_failure({"grasp": {"score": 0.5}, "failure": "the object was not lifted"})


@pytest.mark.slow
def test_a_grasp_that_fails_is_followed_by_another_one(monkeypatch):
    """The first closing is made to fail: the hand then looks again and grasps otherwise."""
    honest = approach._legs

    def feeble(*args):
        legs = honest(*args)
        feeble.calls += 1
        if feeble.calls > 1:
            return legs
        open_hand = np.zeros_like(legs[-1].motors)
        return tuple(dc.replace(leg, motors=open_hand) for leg in legs)

    feeble.calls = 0
    monkeypatch.setattr(approach, "_legs", feeble)
    scenario = dc.replace(SCENARIO, touches=0, attempts=2)
    result = run_trial(scenario).result
    first, second = result["attempts"]
    assert first["grasp"]["robot_feels_it_held"] is False
    assert not first["lift"]["lifted"]
    assert second["grasp"]["robot_feels_it_held"] is True
    assert second["grasp"]["felt_weight_n"] == pytest.approx(9.81 * result["mass_kg"], rel=0.3)
    assert result["lifted"]
    assert not np.allclose(first["grasp"]["X_WH"], second["grasp"]["X_WH"], atol=0.01)


@pytest.mark.slow
def test_a_touch_corrects_a_camera_that_is_badly_calibrated():
    camera = {"calibration_shift_m": 0.01, "calibration_turn_deg": 3.0}
    values = {"seed": 5, "contact": "point", "time_step_s": POINT_STEP_S, "attempts": 1}
    result = run_trial(make_scenario({**values, "camera": camera})).result
    assert result["surface_error_before_touch_mm"] > 6.0
    assert result["surface_error_mm"] < 0.6 * result["surface_error_before_touch_mm"]
    assert np.linalg.norm(result["touches"][0]["view_shift_m"]) > 0.01
    assert result["lifted"]


@pytest.mark.slow
@pytest.mark.parametrize("step_s", [0.001, 0.0015])
def test_a_hand_that_speeds_up_feels_no_touch_whatever_the_plant_s_step(step_s):
    scenario = Scenario(contact="point", time_step_s=step_s, seed=1, object="banana")
    trial = make_trial(scenario)
    simulator = Simulator(trial.diagram, trial.context)
    context = trial.decision.GetMyContextFromRoot(trial.context)
    story = trial.decision.GetOutputPort("story")
    while not story.Eval(context).touches:
        simulator.AdvanceTo(trial.context.get_time() + 0.1)
        assert trial.context.get_time() < 12.0
    (touch,) = story.Eval(context).touches
    X_WO = Judge(trial.station, trial.model, trial.context).object_pose().GetAsMatrix4()
    mesh = trial.model.mesh.transformed(X_WO)
    assert touch.felt
    assert distance_to_surface(mesh, touch.p_WC[None])[0] < 0.005
