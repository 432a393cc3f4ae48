import dataclasses as dc
import itertools

import numpy as np
import pytest
from leaf import Leaf
from pydrake.math import RigidTransform

from vh_drake.control.cartesian_position import pose_error
from vh_drake.geometry.model_files import models_folder
from vh_drake.grasping.closing_pose import closing_offset
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.program import Leg, MotionProgram, interpolate, smooth
from vh_drake.systems.grasp_executor import (
    PATIENCE_S,
    PERIOD_S,
    PRESS_OVER_N,
    YIELD_MOST_M,
    YIELD_MOST_M_S,
    YIELD_OVER_N,
    GraspExecutor,
)
from vh_drake.types import TouchPlan

HAND = read_hand_model(load_hand(models_folder() / "armar6_hand" / "armar6_hand.yaml"))
OPEN, CLOSED = np.zeros(2), np.ones(2)


def place(x=0.0, y=0.0, z=1.0):
    X = np.eye(4)
    X[:3, 3] = [x, y, z]
    return X


HOME, THERE = place(), place(0.1, 0.05, 1.1)
GO = Leg("go", THERE, np.array([0.5, 0.25]), 0.5)
GUARDED = Leg("feel", THERE, OPEN, 1.0, guarded=True)
PLAN = TouchPlan(p_WT=np.array([0.1, 0.0, 1.0]), n_WT=np.array([-1.0, 0.0, 0.0]))
TOUCH = Leg("touch", THERE, OPEN, 1.0, guarded=True, touch=PLAN)


def executor(*legs, caching=True, **inputs):
    """One that has just begun a program."""
    given = {
        "program": MotionProgram(1, legs),
        "hand_pose": RigidTransform(HOME),
        "motor_fraction": OPEN,
        "contact": 0.0,
        "force": np.zeros(3),
        "missed": 0.0,
    }
    leaf = Leaf(GraspExecutor(HAND, HOME), caching=caching, **(given | inputs))
    return leaf.advance(PERIOD_S / 2)


def target(leaf):
    return leaf.get("target_pose").GetAsMatrix4()


def at(leaf, X_WH):
    return leaf.fix(hand_pose=RigidTransform(X_WH))


@pytest.mark.parametrize("caching", [True, False])
def test_a_leg_moves_hand_and_motors_together(caching):
    leaf = executor(GO, caching=caching)
    for _ in range(4):
        leaf.advance(0.1)
        share = leaf.context.get_time() / 0.5
        np.testing.assert_allclose(
            target(leaf), interpolate(HOME, THERE, smooth(share)), atol=1e-12
        )
        np.testing.assert_allclose(leaf.get("motor_command"), share * GO.motors, atol=1e-12)
        assert leaf.get("progress").leg == "go"
        assert leaf.get("progress").done == 0


def test_without_a_program_the_hand_stays_at_its_start():
    leaf = executor(program=MotionProgram())
    leaf.advance(0.3)
    np.testing.assert_array_equal(target(leaf), HOME)
    assert leaf.get("progress").leg == ""


def test_a_leg_ends_when_its_time_is_over_and_the_hand_has_arrived():
    leaf = executor(GO)
    leaf.advance(0.6)
    assert leaf.get("progress").done == 0  # The hand is still where it began.
    at(leaf, THERE).advance(2 * PERIOD_S)
    assert leaf.get("progress").done == 1
    np.testing.assert_allclose(target(leaf), THERE)
    np.testing.assert_allclose(leaf.get("motor_command"), GO.motors)


def test_a_hand_that_never_arrives_is_not_waited_for_endlessly():
    leaf = executor(GO)
    leaf.advance(0.5 + PATIENCE_S - 0.1)
    assert leaf.get("progress").done == 0
    leaf.advance(0.2)
    assert leaf.get("progress").done == 1


def test_a_turned_hand_has_not_arrived():
    turned = THERE.copy()
    turned[:3, :3] = [[np.cos(0.1), -np.sin(0.1), 0], [np.sin(0.1), np.cos(0.1), 0], [0, 0, 1]]
    leaf = at(executor(GO), turned)
    leaf.advance(0.7)
    assert leaf.get("progress").done == 0


def test_a_guarded_leg_ends_at_a_contact_and_stays_there():
    leaf = executor(GUARDED)
    leaf.advance(0.3)
    here = place(0.03, 0.01, 1.03)
    at(leaf, here).fix(contact=1.0).advance(2 * PERIOD_S)
    assert leaf.get("progress").done == 1
    assert leaf.get("progress").felt
    np.testing.assert_allclose(target(leaf), here)


def test_a_guarded_leg_that_meets_nothing_goes_on_unfelt():
    leaf = at(executor(GUARDED, dc.replace(GO, name="next")), THERE)
    leaf.advance(1.0 + 2 * PERIOD_S)
    assert leaf.get("progress").leg == "next"
    assert not leaf.get("progress").felt


def test_a_contact_does_not_end_a_leg_without_guard():
    leaf = executor(GO, contact=1.0, force=[0.0, 0.0, 50.0])
    leaf.advance(0.4)
    assert leaf.get("progress").leg == "go"


def test_a_leg_with_a_force_guard_heeds_the_force_alone():
    guarded = dc.replace(GUARDED, guard_n=4.0)
    leaf = executor(guarded, contact=1.0, force=[0.0, 3.0, -2.0])
    leaf.advance(0.2)
    assert leaf.get("progress").leg == "feel"
    leaf.fix(force=[0.0, 3.0, -3.0]).advance(2 * PERIOD_S)
    assert leaf.get("progress").felt


def test_a_contact_from_before_the_tare_is_not_taken_for_one():
    """The estimator needs a period to answer the tare with a fresh contact flag."""
    leaf = executor(GUARDED, contact=1.0)
    assert leaf.get("progress").leg == "feel"
    leaf.fix(contact=0.0).advance(0.2)
    assert leaf.get("progress").leg == "feel"


def test_each_guarded_leg_asks_for_a_tare_once():
    leaf = executor(GO, GUARDED, dc.replace(GUARDED, X_WH=HOME, name="back"), GO)
    tares = []
    for X_WH in (THERE, THERE, HOME, THERE):
        tares.append((leaf.get("progress").leg, float(leaf.get("tare")[0])))
        at(leaf, X_WH).advance(1.1 if leaf.get("progress").leg != "go" else 0.6)
    assert tares == [("go", 0.0), ("feel", 1.0), ("back", 2.0), ("go", 2.0)]


def test_the_approach_direction_is_that_of_a_guarded_leg_only():
    np.testing.assert_array_equal(executor(GO).get("approach_direction"), 0.0)
    way = THERE[:3, 3] - HOME[:3, 3]
    np.testing.assert_allclose(
        executor(GUARDED).get("approach_direction"), way / np.linalg.norm(way)
    )
    last = PLAN.control_points[3] - PLAN.control_points[2]
    direction = executor(TOUCH).get("approach_direction")
    np.testing.assert_allclose(direction, last / max(np.linalg.norm(last), 1e-9))


def test_a_touch_is_driven_by_the_follower_until_it_is_missed():
    leaf = executor(TOUCH, GO)
    assert leaf.get("follow")[0] == 1.0
    assert leaf.get("touch_plan") is PLAN
    leaf.advance(3.0)
    assert leaf.get("progress").leg == "touch"  # Its duration does not end it.
    beyond = place(0.13)
    at(leaf, beyond).fix(missed=1.0).advance(2 * PERIOD_S)
    assert leaf.get("progress").done == 1  # The legs that follow are left out.
    assert not leaf.get("progress").felt
    assert leaf.get("follow")[0] == 0.0
    np.testing.assert_allclose(target(leaf), beyond)


def test_a_touch_ends_at_its_contact():
    leaf = executor(TOUCH)
    leaf.advance(0.3)
    leaf.fix(contact=1.0).advance(2 * PERIOD_S)
    assert leaf.get("progress").done == 1
    assert leaf.get("progress").felt


def test_a_rise_goes_up_from_where_the_hand_is():
    start = place(0.07, -0.02, 1.2)
    leaf = executor(Leg("lift", HOME, CLOSED, 0.4, rise_m=0.15), hand_pose=RigidTransform(start))
    leaf.advance(0.39)
    np.testing.assert_allclose(target(leaf)[:2, 3], start[:2, 3], atol=1e-12)
    assert target(leaf)[2, 3] == pytest.approx(1.35, abs=1e-3)
    at(leaf, place(0.07, -0.02, 1.35)).advance(0.05)
    assert leaf.get("progress").done == 1


@pytest.mark.parametrize("caching", [True, False])
def test_a_closing_hand_follows_the_measured_travel(caching):
    leg = Leg("close", HOME, CLOSED, 0.5, closing="collect")
    leaf = executor(leg, motor_fraction=[0.2, 0.1], caching=caching)
    np.testing.assert_allclose(target(leaf), HOME, atol=1e-12)
    leaf.fix(motor_fraction=[0.6, 0.3])
    start, now = (closing_offset(HAND, "collect", np.array(f)) for f in ([0.2, 0.1], [0.6, 0.3]))
    expected = HOME @ np.linalg.inv(start) @ now
    np.testing.assert_allclose(target(leaf), expected, atol=1e-12)
    assert np.abs(expected - HOME).max() > 0.005
    leaf.advance(0.3)  # Time alone moves the motors, not the hand.
    np.testing.assert_allclose(target(leaf), expected, atol=1e-12)


@pytest.mark.parametrize("caching", [True, False])
def test_closing_legs_join_where_the_target_is_not_where_the_hand_lags(caching):
    press = Leg("press", HOME, np.array([0.4, 0.4]), 0.3, closing="collect", yields=True)
    squeeze = Leg("squeeze", HOME, CLOSED, 0.3, closing="collect", stands=True)
    legs = (press, dc.replace(press, name="close"), squeeze)
    leaf = executor(*legs, motor_fraction=[0.2, 0.1], force=[3.0, 0.0, 0.0], caching=caching)
    leaf.fix(motor_fraction=[0.4, 0.4])
    for name in ("close", "squeeze"):
        leaf.advance(0.28)
        before = target(leaf)
        at(leaf, HOME).advance(2 * PERIOD_S)  # The hand has not moved at all.
        assert leaf.get("progress").leg == name
        np.testing.assert_allclose(target(leaf), before, atol=YIELD_MOST_M_S * 3 * PERIOD_S)
    assert np.linalg.norm(before[:3, 3] - HOME[:3, 3]) > 0.01


@pytest.mark.parametrize("caching", [True, False])
@pytest.mark.parametrize(
    "leg",
    [
        GO,
        GUARDED,
        Leg("close", HOME, CLOSED, 0.5, closing="collect"),
        Leg("close", HOME, CLOSED, 0.5, closing="collect", tape=True),
    ],
    ids=["free", "guarded", "closing", "tape"],
)
def test_the_target_velocity_is_the_rate_of_the_target(leg, caching):
    leaf, poses, velocities = executor(leg, caching=caching), [], []
    for _ in range(20):
        leaf.fix(motor_fraction=leaf.get("motor_command"))
        poses.append(target(leaf))
        velocities.append(leaf.get("target_velocity"))
        leaf.advance(PERIOD_S)
    rates = [pose_error(b, a) / PERIOD_S for a, b in itertools.pairwise(poses)]
    assert np.linalg.norm(rates, axis=1).max() > 0.02
    np.testing.assert_allclose(velocities[:-1], rates, atol=1e-6)


def test_a_target_that_stands_has_no_velocity():
    stands = Leg("close", HOME, CLOSED, 5.0, closing="collect", stands=True)
    for legs in ((), (stands,)):
        np.testing.assert_array_equal(executor(*legs).get("target_velocity"), np.zeros(6))


def test_a_tape_follows_the_commanded_travel_whatever_the_fingers_do():
    leg = Leg("close", HOME, CLOSED, 0.5, closing="collect", tape=True)
    leaf = executor(leg)
    leaf.advance(0.3)
    motors = leaf.get("motor_command")
    assert motors.min() > 0.5  # The measured travel is still 0.
    start, now = (closing_offset(HAND, "collect", f) for f in (OPEN, motors))
    np.testing.assert_allclose(target(leaf), HOME @ np.linalg.inv(start) @ now, atol=1e-12)


def test_a_yielding_hand_moves_level_with_the_force_on_it_and_not_far():
    leg = Leg("close", HOME, CLOSED, 5.0, closing="side", yields=True)
    stiff = executor(dc.replace(leg, yields=False), force=[3.0, 4.0, 5.0]).advance(0.5)
    np.testing.assert_allclose(target(stiff), HOME, atol=1e-12)
    leaf = executor(leg, force=[3.0, 4.0, 5.0])
    leaf.advance(0.5)
    way = target(leaf)[:3, 3] - HOME[:3, 3]
    np.testing.assert_allclose(way / np.linalg.norm(way), [0.6, 0.8, 0.0], atol=1e-9)
    assert np.linalg.norm(way) == pytest.approx(YIELD_MOST_M_S * 0.5, rel=0.1)
    leaf.advance(3.0)
    assert np.linalg.norm(target(leaf)[:3, 3] - HOME[:3, 3]) <= YIELD_MOST_M
    weak = executor(leg, force=[0.9 * YIELD_OVER_N, 0.0, 20.0]).advance(0.5)
    np.testing.assert_allclose(target(weak), HOME, atol=1e-12)


def test_a_hand_that_is_pushed_up_hard_stops_following_its_fingers_and_rises():
    leg = Leg("press", HOME, np.array([0.44, 0.5]), 1.0, closing="collect", yields=True)
    leaf = executor(leg, motor_fraction=[0.4, 0.3], force=[0.0, 0.0, 0.9 * PRESS_OVER_N])
    leaf.advance(2 * PERIOD_S).fix(motor_fraction=[0.42, 0.4])
    leaf.advance(2 * PERIOD_S)
    followed = target(leaf)
    assert np.linalg.norm(followed[:3, 3] - HOME[:3, 3]) > 0.005
    leaf.fix(force=[0.0, 0.0, 1.2 * PRESS_OVER_N]).advance(2 * PERIOD_S)
    leaf.fix(motor_fraction=[0.44, 0.5]).advance(0.2)
    assert followed[2, 3] < target(leaf)[2, 3] < followed[2, 3] + YIELD_MOST_M
    np.testing.assert_allclose(target(leaf)[:2, 3], followed[:2, 3], atol=1e-12)
    np.testing.assert_allclose(target(leaf)[:3, :3], followed[:3, :3], atol=1e-12)


def test_a_hand_that_stands_while_it_closes_follows_no_finger():
    leg = Leg("close", HOME, CLOSED, 5.0, closing="collect", yields=True, stands=True)
    leaf = executor(leg, motor_fraction=[0.4, 0.4])
    leaf.fix(motor_fraction=[0.6, 0.5]).advance(0.1)
    np.testing.assert_allclose(target(leaf), HOME, atol=1e-12)
    leaf.fix(force=[3.0, 0.0, 0.0]).advance(0.1)
    assert target(leaf)[0, 3] > HOME[0, 3]


def weighing(force):
    """A hand that has closed, lifts, and wants to feel a weight of 1 N at the end."""
    close = Leg("close", HOME, CLOSED, 0.3, closing="side")
    seek = Leg("seek", HOME, OPEN, 0.3, seek_m=0.02)
    lift = Leg("lift", HOME, CLOSED, 0.3, rise_m=0.0, least_load_n=1.0, otherwise=(seek, GO))
    leaf = executor(close, lift, dc.replace(GO, name="on"), force=[2.0, 0.0, 0.0])
    leaf.advance(0.35)
    assert leaf.get("progress").leg == "lift"
    return leaf.fix(force=force).advance(0.32)


def test_a_hand_that_feels_the_weight_goes_on():
    assert weighing([0.0, 0.0, -1.5]).get("progress").leg == "on"


def test_an_empty_hand_seeks_the_object_where_it_resisted():
    leaf = weighing([0.0, 0.0, -0.5])
    assert leaf.get("progress").leg == "seek"
    leaf.advance(0.4)  # What pushed the hand along +x lies before it along -x.
    np.testing.assert_allclose(target(leaf)[:3, 3] - HOME[:3, 3], [-0.02, 0, 0], atol=1e-9)
    at(leaf, place(-0.02)).advance(2 * PERIOD_S)
    assert leaf.get("progress").leg == "go"


def test_a_new_id_starts_a_new_program_from_here_without_a_jump():
    leaf = executor(GO)
    leaf.advance(0.2)
    here, motors = place(0.03, 0.02, 1.02), leaf.get("motor_command")
    again = MotionProgram(2, (Leg("back", HOME, OPEN, 0.5),))
    at(leaf, here).fix(program=again).advance(PERIOD_S)
    assert leaf.get("progress").leg == "back"
    np.testing.assert_allclose(target(leaf), here, atol=1e-4)
    np.testing.assert_allclose(leaf.get("motor_command"), motors, atol=0.03)


def test_the_same_id_does_not_start_a_program_again():
    leaf = at(executor(GO), THERE)
    leaf.advance(0.6)
    leaf.fix(program=MotionProgram(1, (GUARDED,))).advance(0.1)
    assert leaf.get("progress").done == 1
    assert leaf.get("progress").leg == ""


def test_an_empty_program_is_done_at_once_and_stops_the_hand_here():
    leaf = executor(GO)
    leaf.advance(0.2)
    here = place(0.03, 0.02, 1.02)
    at(leaf, here).fix(program=MotionProgram(2)).advance(2 * PERIOD_S)
    assert leaf.get("progress").done == 2
    np.testing.assert_array_equal(target(leaf), here)


def test_two_contexts_do_not_touch_each_other():
    leaf = executor(GO)
    other = Leaf(
        leaf.system,
        program=MotionProgram(),
        hand_pose=RigidTransform(HOME),
        motor_fraction=OPEN,
        contact=0.0,
        force=np.zeros(3),
        missed=0.0,
    )
    other.advance(0.2)
    leaf.advance(0.2)
    assert leaf.get("progress").leg == "go"
    assert other.get("progress").leg == ""
    np.testing.assert_array_equal(target(other), HOME)
