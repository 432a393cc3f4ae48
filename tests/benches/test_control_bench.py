import numpy as np
import pytest
from scenery import right_arm, right_hand

from vh_drake.benches.control import (
    HIGH,
    LOW,
    PERIOD_S,
    carried_out,
    drakes,
    ours,
    reaches,
)
from vh_drake.control.reach import rollout

ARM, HAND = right_arm(), right_hand()


@pytest.fixture(scope="module")
def tasks():
    return reaches(ARM, HAND, 3, 5)


def shifted(q, offset):
    X_WH = ARM.pose(q)
    X_WH[:3, 3] += offset
    return X_WH


def test_reaches_start_within_the_limits_and_end_over_the_table(tasks):
    p_HP = np.array(HAND.description.tcps["power"])
    for q, X_WH in tasks:
        assert np.all((q >= ARM.lower) & (q <= ARM.upper))
        for X in (ARM.pose(q), X_WH):
            p_WP = X[:3, :3] @ p_HP + X[:3, 3]
            assert np.all((p_WP >= LOW - 1e-3) & (p_WP <= HIGH + 1e-3))


def test_the_same_seed_gives_the_same_reaches(tasks):
    for (q, X), (q_again, X_again) in zip(tasks, reaches(ARM, HAND, 3, 5), strict=True):
        np.testing.assert_array_equal(q, q_again)
        np.testing.assert_array_equal(X, X_again)


@pytest.mark.parametrize("controller", [ours, drakes])
def test_a_near_pose_is_reached_by_either_without_a_word(controller, capfd):
    times = []
    goal = shifted(ARM.home, [0.04, 0.03, -0.03])
    result = carried_out(ARM, controller(ARM), ARM.home, goal, times)
    assert result.reached
    assert len(times) == round(result.duration_s / PERIOD_S)
    assert min(times) > 0.0
    assert capfd.readouterr().out == ""


def test_ours_fares_as_the_rollout_says():
    goal = shifted(ARM.home, [0.15, 0.1, -0.1])
    result = carried_out(ARM, ours(ARM), ARM.home, goal, [])
    expected = rollout(ARM, ARM.home, [goal], dt=PERIOD_S)
    assert result.reached
    assert result.duration_s == pytest.approx(expected.duration_s, abs=PERIOD_S)
    ways = [ARM.pose(q)[:3, 3] for q in expected.q]
    line = (goal[:3, 3] - ways[0]) / np.linalg.norm(goal[:3, 3] - ways[0])
    off = [np.linalg.norm(np.cross(p - ways[0], line)) for p in ways]
    assert result.deviation_mm == pytest.approx(1e3 * max(off), abs=0.05)


def test_a_pose_beyond_the_arm_is_given_up():
    result = carried_out(ARM, ours(ARM), ARM.home, shifted(ARM.home, [3.0, 0.0, 0.0]), [])
    assert not result.reached
    assert result.duration_s < 8.0
