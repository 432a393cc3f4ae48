import numpy as np
import pytest
from leaf import Leaf
from scenery import can_surface, can_view, right_arm, right_hand, touch_of_the_can

from vh_drake.grasping.surface_planner import PlannerSettings, plan_candidates
from vh_drake.hand.program import Progress
from vh_drake.systems.behaviour import PERIOD_S, Behaviour, BehaviourSettings
from vh_drake.types import Candidates, ContactSet, GraspScores, ObjectView, Surface

BACK = touch_of_the_can(0.0)
SIDE = touch_of_the_can(0.5 * np.pi)
FELT = ContactSet(np.array([[0.741, -0.3, 0.97]]), np.array([[1.0, 0.0, 0.0]]))


@pytest.fixture(scope="module")
def candidates():
    view = can_view()
    settings = PlannerSettings(candidates=20, draws=100)
    return plan_candidates(can_surface(), view.table, right_hand(), settings, 0)


def behaviour(*, caching=True, system=None, touches=1, **inputs):
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
        "joint_state": np.concatenate([right_arm().home, np.zeros(8)]),
    }
    system = system or Behaviour(right_hand(), right_arm(), BehaviourSettings(touches=touches))
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
    assert record.candidates == {"surface": len(far)}
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
