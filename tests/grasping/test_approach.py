import dataclasses as dc
import itertools

import numpy as np
import pytest
from scenery import can_scene, can_surface, can_view, right_arm, right_hand

from vh_drake.control.reach import rollout
from vh_drake.grasping.approach import (
    GraspMotionSettings,
    approach_poses,
    closing_legs,
    find_grasp,
    release_legs,
)
from vh_drake.grasping.phases import hand_is_open
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.clearance import link_clearance
from vh_drake.hand.program import interpolate
from vh_drake.types import Candidates

SETTINGS = GraspMotionSettings()


@pytest.fixture(scope="module")
def side_grasps():
    settings = PlannerSettings(candidates=20, draws=100)
    return plan_candidates(can_surface(), can_view().table, right_hand(), settings, 0)


def found(candidates, ranking):
    arm = right_arm()
    return find_grasp(candidates, ranking, can_scene(), right_hand(), arm, arm.home)


def with_motion(candidates, motion):
    return dc.replace(candidates, motion=(motion,) * len(candidates))


def test_the_first_of_the_ranking_in_reach_is_taken(side_grasps):
    index, _ = found(side_grasps, range(len(side_grasps)))
    ranking = [len(side_grasps) - 1 - i for i in range(len(side_grasps))]
    other, _ = found(side_grasps, ranking)
    for i in range(index):
        assert found(side_grasps, [i]) is None
    for i in ranking[: ranking.index(other)]:
        assert found(side_grasps, [i]) is None


def test_no_ranking_and_no_reach_give_no_grasp(side_grasps):
    away = side_grasps.X_WH.copy()
    away[:, 0, 3] += 3.0
    far = Candidates(away, side_grasps.motion, side_grasps.planner)
    assert found(side_grasps, []) is None
    assert found(far, range(len(far))) is None


def test_a_side_grasp_comes_along_the_palm_s_direction(side_grasps):
    hand, X_WH = right_hand(), side_grasps.X_WH[0]
    now = right_arm().pose(right_arm().home)
    *_, beside, last = approach_poses(X_WH, "side", can_scene(), hand, now, SETTINGS)
    np.testing.assert_array_equal(last, X_WH)
    np.testing.assert_allclose(beside[:3, :3], X_WH[:3, :3])
    palm = X_WH[:3, :3] @ np.asarray(hand.description.palm)
    way = last[:3, 3] - beside[:3, 3]
    np.testing.assert_allclose(way, SETTINGS.standoff_m * palm, atol=1e-12)


@pytest.mark.parametrize("motion", ["side", "collect"])
def test_the_hand_travels_level_and_over_the_object(side_grasps, motion):
    hand, scene, X_WH = right_hand(), can_scene(), side_grasps.X_WH[0]
    now = right_arm().pose(right_arm().home)
    raised, over, *_ = approach_poses(X_WH, motion, scene, hand, now, SETTINGS)
    assert raised[2, 3] == pytest.approx(over[2, 3])
    assert raised[2, 3] >= now[2, 3] - 1e-12
    np.testing.assert_allclose(raised[:2, 3], now[:2, 3])
    lowest = link_clearance(hand, over, scene)[1]
    assert lowest >= scene.top_m + SETTINGS.safe_height_m - 1e-9


def test_legs_close_only_after_the_guarded_approach_and_then_lift(side_grasps):
    index, legs = found(side_grasps, range(len(side_grasps)))
    names = [leg.name for leg in legs]
    assert names[-5:] == ["approach", "close", "squeeze", "lift", "hold"]
    guarded = [leg.name for leg in legs if leg.guarded]
    assert guarded == ["approach"]
    approach = legs[names.index("approach")]
    assert approach.guard_n == SETTINGS.guard_n
    np.testing.assert_array_equal(approach.X_WH, side_grasps.X_WH[index])
    for leg in legs[: names.index("close")]:
        np.testing.assert_array_equal(leg.motors, 0.0)
    for leg in legs[names.index("close") :]:
        np.testing.assert_array_equal(leg.motors, 1.0)
    lift, hold = legs[-2:]
    assert (lift.rise_m, hold.rise_m) == (SETTINGS.rise_m("side"), 0.0)
    assert hold.duration_s > 3.0


def test_a_collecting_grasp_gathers_first(side_grasps):
    collect = with_motion(side_grasps, "collect")
    grasp = found(collect, range(len(collect)))
    assert grasp is not None
    legs = {leg.name: leg for leg in grasp[1]}
    assert "down beside the object" not in legs
    pressing = right_hand().description.pressing
    np.testing.assert_array_equal(legs["gather"].motors, pressing.gathered)
    np.testing.assert_array_equal(legs["press"].motors, pressing.pressed)
    names = ("gather", "press", "close", "squeeze")
    assert all(legs[name].closing == "collect" for name in names)
    assert [legs[name].stands for name in names] == [False, False, True, True]


def test_a_hand_that_does_not_press_closes_by_the_settings():
    hand = right_hand()
    hand = dc.replace(hand, description=dc.replace(hand.description, pressing=None))
    legs = closing_legs(np.eye(4), "collect", hand, SETTINGS)
    assert [leg.name for leg in legs] == ["gather", "close", "squeeze", "lift", "hold"]
    half = hand.motor_fractions(SETTINGS.gather_fingers, SETTINGS.gather_thumb)
    np.testing.assert_array_equal(legs[0].motors, half)
    assert not any(leg.stands for leg in legs)


def test_an_open_loop_plays_a_tape_and_a_closed_one_does_not():
    hand, X_WH = right_hand(), np.eye(4)
    for closing, tape in (("open_loop", True), ("closed_loop", False)):
        settings = dc.replace(SETTINGS, closing=closing, yields=True, weigh_m=0.02)
        legs = closing_legs(X_WH, "collect", hand, settings)
        fingers = [leg for leg in legs if leg.closing]
        assert [leg.name for leg in fingers] == ["gather", "press", "close", "squeeze"]
        assert all(leg.tape == tape and leg.yields != tape for leg in fingers)
        assert any(leg.otherwise for leg in legs) != tape
        assert sum(leg.rise_m or 0.0 for leg in legs) == pytest.approx(SETTINGS.rise_m("collect"))


def test_an_empty_hand_closes_once_more_from_where_it_began():
    settings = dc.replace(SETTINGS, weigh_m=0.02)
    legs = closing_legs(np.eye(4), "collect", right_hand(), settings)
    (weighed,) = [leg for leg in legs if leg.otherwise]
    assert weighed.least_load_n > 0
    again = weighed.otherwise
    assert again[0].rise_m == pytest.approx(-weighed.rise_m)
    assert not any(leg.otherwise for leg in again)
    names = [leg.name for leg in again]
    assert names[1:4] == ["open again", "seek", "gather"]
    assert not any(hand_is_open(f"grasp: {name}") for name in names)


def test_the_arm_follows_the_approach_and_the_lift(side_grasps):
    arm = right_arm()
    _, legs = found(side_grasps, range(len(side_grasps)))
    way = [leg.X_WH for leg in legs if not leg.closing and leg.rise_m is None]
    lifted = way[-1].copy()
    lifted[2, 3] += SETTINGS.lift_m
    assert rollout(arm, arm.home, [*way, lifted]).reached


def test_a_way_that_collides_is_refused_and_the_next_one_taken(side_grasps):
    arm, hand = right_arm(), right_hand()

    class Refusing:
        """Finds a collision in the first motions that it is asked about."""

        def __init__(self, count):
            self.count, self.heights = count, []

        def first(self, q, table_height_m):
            self.heights.append(table_height_m)
            return "collision" if len(self.heights) <= self.count else None

    order = range(len(side_grasps))
    plain = find_grasp(side_grasps, order, can_scene(), hand, arm, arm.home)
    twice = Refusing(2)
    later = find_grasp(side_grasps, order, can_scene(), hand, arm, arm.home, collisions=twice)
    assert later[0] > plain[0]
    np.testing.assert_allclose(twice.heights, 0.9)
    never = Refusing(1000)
    assert (
        find_grasp(side_grasps, order, can_scene(), hand, arm, arm.home, collisions=never) is None
    )


class LowWaysCollide:
    """Takes every way that starts with the hand lower than a height over the floor for barred."""

    def __init__(self, lowest_m):
        self.lowest_m, self.asked = lowest_m, []

    def first(self, q, table_height_m):
        self.asked.append(table_height_m)
        return "barred" if right_arm().pose(q[0])[2, 3] < self.lowest_m else None


def released(collisions):
    arm, table = right_arm(), can_view().table
    q = arm.home + np.array([0.0, 0.2, 0, 0, 0, 0, 0, 0])
    return arm.pose(q), release_legs(right_hand(), arm, q, table, collisions=collisions)


def test_a_hand_that_lets_go_opens_rises_and_comes_home():
    X_WH, (opened, raised, home) = released(None)
    np.testing.assert_array_equal(opened.motors, right_hand().motor_fractions(0.0, 0.0))
    np.testing.assert_allclose(opened.X_WH, X_WH)
    np.testing.assert_allclose(raised.X_WH[:3, 3] - X_WH[:3, 3], [0, 0, 0.05], atol=1e-9)
    np.testing.assert_allclose(home.X_WH, right_arm().pose(right_arm().home))


def test_it_rises_as_far_as_the_way_back_is_free():
    X_WH, _ = released(None)
    collisions = LowWaysCollide(X_WH[2, 3] + 0.12)
    legs = released(collisions)[1]
    assert legs[1].X_WH[2, 3] - X_WH[2, 3] == pytest.approx(0.15)
    np.testing.assert_allclose(collisions.asked, can_view().table.offset, atol=1e-9)


def test_a_hand_that_can_not_go_over_the_object_goes_from_home_straight_beside_it(side_grasps):
    arm, hand, scene = right_arm(), right_hand(), can_scene()
    home = arm.pose(arm.home)
    ways = []

    class OverIsBarred:
        """Finds a collision wherever the hand comes from above."""

        def first(self, q, table_height_m):
            ways.append(max(arm.pose(row)[2, 3] for row in q[: len(q) // 2]))
            return "collision" if len(ways) % 2 else None

    order = range(len(side_grasps))
    index, legs = find_grasp(
        side_grasps, order, scene, hand, arm, arm.home, collisions=OverIsBarred()
    )
    assert found(side_grasps, order)[0] == index
    assert ways[1] <= ways[0] + 1e-9
    np.testing.assert_allclose(legs[1].X_WH, home, atol=1e-9)
    palm = side_grasps.X_WH[index][:3, :3] @ np.asarray(hand.description.palm)
    beside = side_grasps.X_WH[index][:3, 3] - SETTINGS.standoff_m * palm
    np.testing.assert_allclose(legs[2].X_WH[:3, 3], beside, atol=1e-9)
    for first, second in itertools.pairwise(legs[:3]):
        for share in np.linspace(0, 1, 60):
            X_WH = interpolate(first.X_WH, second.X_WH, share)
            assert link_clearance(hand, X_WH, scene)[0].min() > 0.015
