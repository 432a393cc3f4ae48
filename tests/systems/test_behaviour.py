import dataclasses as dc
from collections import Counter

import numpy as np
import pytest
from leaf import Leaf
from scenery import can_surface, can_view, right_arm, right_hand, touch_of_the_can

from vh_drake.control.reach import rollout
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.program import Leg, Progress
from vh_drake.systems import behaviour as behaviours
from vh_drake.systems.behaviour import PERIOD_S, Behaviour, BehaviourSettings
from vh_drake.types import Candidates, ContactSet, GraspScores, ObjectView, Surface

BACK = touch_of_the_can(0.0)
SIDE = touch_of_the_can(0.5 * np.pi)
CARRIED, EMPTY = np.array([0.1, 0.0, -2.0]), np.array([0.1, 0.05, -0.02])  # [N]
CLOSED, KEPT_OPEN = np.array([0.9, 0.85]), np.array([0.64, 0.62])
FELT = ContactSet(np.array([[0.741, -0.3, 0.97]]), np.array([[1.0, 0.0, 0.0]]))


@pytest.fixture(scope="module")
def candidates():
    view = can_view()
    settings = PlannerSettings(candidates=20, draws=100)
    return plan_candidates(can_surface(), view.table, right_hand(), settings, 0)


def behaviour(*, caching=True, system=None, touches=1, attempts=1, **inputs):
    """One that has not looked yet."""
    given = {
        "object_view": can_view(),
        "view_status": "ok",
        "surface": can_surface(),
        "surface_served": 0,
        "touch_plans": (BACK,),
        "touch_served": 0,
        "candidates": Candidates(),
        "scores": GraspScores(),
        "ranking": (),
        "grasp_served": 0,
        "progress": Progress(),
        "contact_point": ContactSet(),
        "force": CARRIED,
        "joint_state": np.concatenate([right_arm().home, np.zeros(8)]),
        "motor_fraction": CLOSED,
    }
    settings = BehaviourSettings(touches=touches, attempts=attempts)
    system = system or Behaviour(right_hand(), right_arm(), settings)
    leaf = Leaf(system, caching=caching, **(given | inputs))
    return leaf.advance(PERIOD_S / 2)


def step(leaf, **inputs):
    """Another update, with other inputs; the phase after it."""
    return leaf.fix(**inputs).advance(PERIOD_S).get("story").phase


def looked(**inputs):
    leaf = behaviour(**inputs)
    leaf.advance(0.1)
    return leaf


def touching(**inputs):
    """One whose touch is under way."""
    leaf = looked(**inputs)
    step(leaf, surface_served=1)
    assert step(leaf, touch_served=1) == "touch"
    return leaf


def end_touch(leaf, *, felt):
    """The executor reports the end of the touch, then that of the retreat."""
    program = leaf.get("program").id
    step(leaf, progress=Progress(program, "", felt), contact_point=FELT if felt else ContactSet())
    if felt:
        assert leaf.get("story").phase == "touch"  # It rests where it touched.
        leaf.advance(BehaviourSettings().feel_s + PERIOD_S)
    assert leaf.get("story").phase == "retreat"
    assert leaf.get("program").id == program + 1
    step(leaf, progress=Progress(program + 1))


def test_it_waits_until_the_arm_is_at_rest_before_it_looks():
    leaf = behaviour()
    assert leaf.get("story").phase == "look"
    assert leaf.get("surface_request")[0] == 0
    leaf.advance(0.1)
    assert leaf.get("story").phase == "estimate"
    assert leaf.get("surface_request")[0] == 1


def test_the_first_look_is_kept():
    leaf = looked()
    leaf.fix(object_view=ObjectView(), view_status="no object")
    leaf.advance(0.1)
    assert leaf.get("view") is can_view()
    assert leaf.get("story").phase == "estimate"


def test_where_nothing_is_seen_it_gives_up_with_the_reason():
    leaf = looked(view_status="no table in view")
    story = leaf.get("story")
    assert (story.phase, story.finished) == ("failed", True)
    assert story.failure == "no table in view"
    assert leaf.get("surface_request")[0] == 0


def test_an_estimate_of_an_old_request_is_not_taken():
    leaf = looked()
    assert step(leaf, surface_served=0) == "estimate"
    assert step(leaf, surface_served=1) == "plan a touch"
    assert leaf.get("touch_request")[0] == 1


def test_an_estimate_without_surface_ends_the_trial():
    leaf = looked(surface=Surface())
    assert step(leaf, surface_served=1) == "failed"
    assert "no surface" in leaf.get("story").failure


def test_without_touches_grasps_are_planned_at_once():
    leaf = looked(touches=0)
    assert step(leaf, surface_served=1) == "plan grasps"
    assert leaf.get("grasp_request")[0] == 1


@pytest.mark.parametrize("caching", [True, False])
def test_a_felt_touch_adds_a_contact_and_asks_for_a_new_estimate(caching):
    leaf = touching(caching=caching)
    program = leaf.get("program")
    assert [leg.name for leg in program.legs][-1] == "feel"
    assert leaf.get("phase") == "touch"
    leaf.fix(progress=Progress(0, "feel"))
    assert leaf.get("phase") == "touch: feel"  # Without an update of the state.
    end_touch(leaf, felt=True)
    np.testing.assert_array_equal(leaf.get("contacts").p_WC, FELT.p_WC)
    np.testing.assert_array_equal(leaf.get("contacts").n_WC, FELT.n_WC)
    (record,) = leaf.get("story").touches
    assert record.felt
    np.testing.assert_array_equal(record.p_WC, FELT.p_WC[0])
    assert leaf.get("story").phase == "estimate"
    assert leaf.get("surface_request")[0] == 2
    assert step(leaf, surface_served=2) == "plan grasps"


def badly_seen():
    """The can, from a camera that may be wrong by 2 cm along y."""
    return dc.replace(can_view(), shift_covariance=np.diag([1e-6, 4e-4, 0.0]))


def touched_before(**inputs):
    """One whose finger met the badly seen can 1 cm before the place where it was seen."""
    leaf = touching(object_view=badly_seen(), touch_plans=(SIDE,), **inputs)
    X_WH = leaf.get("program").legs[-1].X_WH.copy()
    X_WH[:3, 3] += 0.01 * SIDE.n_WT
    arm = right_arm()
    q = rollout(arm, arm.home, [X_WH]).q[-1]
    leaf.fix(joint_state=np.concatenate([q, np.zeros(8)]))
    end_touch(leaf, felt=True)
    return leaf


def test_a_touch_moves_what_a_badly_calibrated_camera_saw():
    leaf = touched_before()
    shift = leaf.get("view").p_WO - can_view().p_WO
    np.testing.assert_allclose(shift, np.tile(shift[0], (len(shift), 1)), atol=1e-12)
    assert shift[0] @ SIDE.n_WT == pytest.approx(0.01, abs=3e-3)
    assert leaf.get("view").shift_covariance[1, 1] < 1e-4
    np.testing.assert_allclose(leaf.get("story").touches[0].view_shift, shift[0], atol=1e-12)
    np.testing.assert_array_equal(leaf.get("contacts").p_WC, FELT.p_WC)


def test_a_touch_moves_nothing_that_a_good_camera_saw():
    leaf = touching()
    end_touch(leaf, felt=True)
    np.testing.assert_array_equal(leaf.get("view").p_WO, can_view().p_WO)


def test_a_missed_touch_adds_no_contact_and_is_not_tried_again():
    leaf = touching()
    end_touch(leaf, felt=False)
    (record,) = leaf.get("story").touches
    assert not record.felt
    assert np.isnan(record.p_WC).all()
    assert len(leaf.get("contacts")) == 0
    assert step(leaf, surface_served=2) == "plan a touch"
    assert step(leaf, touch_served=2, touch_plans=(BACK, SIDE)) == "touch"
    np.testing.assert_allclose(leaf.get("program").legs[-1].touch.p_WT, SIDE.p_WT)


def test_where_only_missed_places_are_left_the_view_must_do():
    leaf = touching()
    end_touch(leaf, felt=False)
    step(leaf, surface_served=2)
    assert step(leaf, touch_served=2, touch_plans=(BACK,)) == "plan grasps"


def test_misses_are_borne_up_to_a_number():
    leaf = touching()
    headings = iter((0.5, 1.0))
    for request in (2, 3):
        end_touch(leaf, felt=False)
        step(leaf, surface_served=request)
        plan = touch_of_the_can(next(headings) * np.pi)
        assert step(leaf, touch_served=request, touch_plans=(plan,)) == "touch"
    end_touch(leaf, felt=False)
    assert step(leaf, surface_served=4) == "plan grasps"
    assert len(leaf.get("story").touches) == 3


def test_a_contact_flag_without_a_place_counts_as_missed():
    leaf = touching()
    program = leaf.get("program").id
    step(leaf, progress=Progress(program, "", True), contact_point=ContactSet())
    leaf.advance(BehaviourSettings().feel_s + PERIOD_S)
    assert not leaf.get("story").touches[0].felt


def test_the_best_ranked_grasp_in_reach_is_executed_and_reported(candidates):
    leaf = looked(touches=0)
    step(leaf, surface_served=1)
    far = candidates.X_WH.copy()
    far[0, :3, 3] += [3.0, 0.0, 0.0]
    far = Candidates(far, candidates.motion, candidates.planner)
    score = np.linspace(0.0, 1.0, len(far))
    ranking = (0, *range(1, len(far)))
    grasping = {"candidates": far, "scores": GraspScores(score), "ranking": ranking}
    assert step(leaf, grasp_served=0, **grasping) == "plan grasps"
    assert step(leaf, grasp_served=1) == "grasp"
    (record,) = leaf.get("story").grasps
    index = ranking[record.rank]
    assert record.rank > 0  # The first is out of reach.
    assert record.score == pytest.approx(score[index])
    np.testing.assert_array_equal(record.X_WH, far.X_WH[index])
    assert record.candidates == dict(Counter(far.planner))
    program = leaf.get("program")
    assert [leg.name for leg in program.legs][-2:] == ["lift", "hold"]
    assert step(leaf, progress=Progress(program.id - 1, "lift")) == "grasp"
    assert step(leaf, progress=Progress(program.id)) == "done"
    assert leaf.get("story").finished
    assert leaf.get("story").failure == ""


def test_grasps_out_of_reach_end_the_trial_with_a_remedy(candidates):
    away = candidates.X_WH.copy()
    away[:, :3, 3] += [3.0, 0.0, 0.0]
    leaf = looked(touches=0)
    step(leaf, surface_served=1)
    grasps = Candidates(away, candidates.motion, candidates.planner)
    phase = step(leaf, grasp_served=1, candidates=grasps, ranking=tuple(range(len(grasps))))
    assert phase == "failed"
    assert "none of 20 planned grasps" in leaf.get("story").failure
    assert leaf.get("program").id == 0


def test_a_planner_without_any_grasp_ends_the_trial():
    leaf = looked(touches=0)
    step(leaf, surface_served=1)
    assert step(leaf, grasp_served=1) == "failed"
    assert "no grasp" in leaf.get("story").failure


def test_two_contexts_do_not_touch_each_other():
    first = looked()
    second = behaviour(system=first.system, view_status="no object")
    second.advance(0.1)
    assert first.get("story").phase == "estimate"
    assert second.get("story").phase == "failed"
    assert len(second.get("view").p_WO) == 0


def test_a_finished_story_stays_as_it_is():
    leaf = looked(view_status="no object")
    story = leaf.get("story")
    leaf.fix(view_status="ok").advance(0.5)
    assert leaf.get("story") is story


def grasping(candidates, **inputs):
    """One whose first grasp is under way."""
    leaf = looked(touches=0, **inputs)
    step(leaf, surface_served=1)
    rated = {
        "candidates": candidates,
        "scores": GraspScores(np.linspace(1.0, 0.9, len(candidates))),
        "ranking": tuple(range(len(candidates))),
    }
    assert step(leaf, grasp_served=1, **rated) == "grasp"
    return leaf


def test_a_hand_that_feels_the_weight_at_the_end_holds_the_object(candidates):
    leaf = grasping(candidates, attempts=3)
    assert step(leaf, progress=Progress(leaf.get("program").id)) == "done"
    (grasp,) = leaf.get("story").grasps
    assert grasp.held
    assert grasp.weight_n == pytest.approx(2.0)


def test_fingers_that_are_kept_open_hold_what_is_too_light_to_be_felt(candidates):
    leaf = grasping(candidates, attempts=3)
    program = leaf.get("program").id
    light = {"force": EMPTY, "motor_fraction": KEPT_OPEN}
    for _ in range(BehaviourSettings().lost_after + 1):
        assert step(leaf, progress=Progress(program - 1, "hold"), **light) == "grasp"
    assert step(leaf, progress=Progress(program), **light) == "done"
    assert leaf.get("story").grasps[0].held


@pytest.mark.parametrize("travel", [(0.9, 0.62), (0.64, 0.85)])
def test_one_motor_that_goes_as_far_as_in_an_empty_hand_tells_that_nothing_is_held(
    candidates, travel
):
    leaf = grasping(candidates, attempts=1)
    end = Progress(leaf.get("program").id)
    assert step(leaf, progress=end, force=EMPTY, motor_fraction=np.array(travel)) == "done"
    assert leaf.get("story").grasps[0].held is False


def test_a_hand_that_has_not_tried_to_close_is_not_kept_open(candidates, monkeypatch):
    legs = (Leg("close", np.eye(4), np.array([0.5, 0.5])),)
    monkeypatch.setattr(behaviours, "find_grasp", lambda *args, **options: (0, legs))
    leaf = grasping(candidates, attempts=1)
    end = Progress(leaf.get("program").id)
    assert step(leaf, progress=end, force=EMPTY, motor_fraction=[0.48, 0.49]) == "done"
    assert leaf.get("story").grasps[0].held is False


def test_an_empty_hand_lets_go_looks_again_and_grasps_elsewhere(candidates):
    leaf = grasping(candidates, attempts=3)
    program = leaf.get("program").id
    assert step(leaf, progress=Progress(program), force=EMPTY) == "let go"
    released = leaf.get("program")
    assert released.id == program + 1
    assert released.legs[0].name == "open the hand"
    assert all(np.all(leg.motors == 0) for leg in released.legs)
    home = right_arm().pose(right_arm().home)
    np.testing.assert_allclose(released.legs[-1].X_WH, home)
    assert step(leaf, progress=Progress(program + 1)) == "look"
    assert step(leaf) == "estimate"
    assert step(leaf, surface_served=2) == "plan grasps"
    assert step(leaf, grasp_served=2, progress=Progress(program + 1)) == "grasp"
    first, second = leaf.get("story").grasps
    assert first.held is False
    assert second.held is None
    assert not np.allclose(first.X_WH, second.X_WH)


def test_a_hand_that_loses_the_object_while_it_holds_does_not_wait_for_the_end(candidates):
    leaf = grasping(candidates, attempts=2)
    holding = Progress(leaf.get("program").id - 1, "hold")
    for _ in range(BehaviourSettings().lost_after - 1):
        assert step(leaf, progress=holding, force=EMPTY) == "grasp"
    assert step(leaf, progress=holding, force=EMPTY) == "let go"


def test_the_camera_s_error_is_still_known_at_the_next_look(candidates):
    leaf = touched_before(attempts=2)
    corrected = leaf.get("view")
    home = np.concatenate([right_arm().home, np.zeros(8)])
    rated = {
        "candidates": candidates,
        "scores": GraspScores(np.ones(len(candidates))),
        "ranking": tuple(range(len(candidates))),
    }
    step(leaf, surface_served=2, joint_state=home)
    assert step(leaf, grasp_served=1, **rated) == "grasp"
    program = leaf.get("program").id
    step(leaf, progress=Progress(program), force=EMPTY)
    step(leaf, progress=Progress(program + 1))
    assert step(leaf) == "estimate"  # It has looked again: the camera shows the can as before.
    np.testing.assert_allclose(leaf.get("view").p_WO, corrected.p_WO, atol=1e-12)
    np.testing.assert_array_equal(leaf.get("view").shift_covariance, corrected.shift_covariance)


def test_a_short_jolt_is_no_loss(candidates):
    leaf = grasping(candidates, attempts=2)
    holding = Progress(leaf.get("program").id - 1, "hold")
    for force in [EMPTY] * 6 + [CARRIED] + [EMPTY] * 6:
        assert step(leaf, progress=holding, force=force) == "grasp"


def test_the_last_attempt_ends_the_trial(candidates):
    leaf = grasping(candidates, attempts=1)
    assert step(leaf, progress=Progress(leaf.get("program").id), force=EMPTY) == "done"
    assert leaf.get("story").grasps[0].held is False


@pytest.mark.parametrize(("shift_m", "kept"), [(0.03, 1), (None, 0)])
def test_what_was_felt_moves_with_the_object_or_is_forgotten(candidates, shift_m, kept):
    leaf = touching(attempts=2)
    end_touch(leaf, felt=True)
    rated = {
        "candidates": candidates,
        "scores": GraspScores(np.ones(len(candidates))),
        "ranking": tuple(range(len(candidates))),
    }
    step(leaf, surface_served=2)
    step(leaf, grasp_served=1, **rated)
    view = can_view()
    if shift_m is None:  # It lies now.
        middle = np.array([0.7, -0.3, 0.97])
        points = (view.p_WO - middle)[:, [0, 2, 1]] + middle - [0.0, 0.0, 0.03]
    else:
        points = view.p_WO + np.array([shift_m, 0.0, 0.0])
    leaf.fix(object_view=ObjectView(points, view.n_WO, view.table, view.p_WCamera))
    program = leaf.get("program").id
    step(leaf, progress=Progress(program), force=EMPTY)
    step(leaf, progress=Progress(program + 1))
    step(leaf)
    contacts = leaf.get("contacts")
    assert len(contacts) == kept
    if kept:
        np.testing.assert_allclose(contacts.p_WC, FELT.p_WC + np.array([shift_m, 0, 0]), atol=4e-3)
    assert step(leaf, surface_served=3) == ("plan grasps" if kept else "plan a touch")
