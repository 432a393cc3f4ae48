import numpy as np
import pytest

from vh_drake.grasping.motions import (
    CollectSettings,
    collect_motion,
    collect_pose,
    side_motion,
    tip_line_pitch,
)

SETTINGS = CollectSettings()


def test_the_open_hand_of_armar6_pitches_by_33_degrees(hand):
    assert np.rad2deg(tip_line_pitch(hand, hand.lower)) == pytest.approx(33, abs=1)


def test_the_tip_line_is_parallel_to_the_table(hand):
    X = collect_pose(hand, hand.lower, SETTINGS)
    palm = np.array([-1.0, 0, 0])
    tips = (hand.tips(hand.lower) + 0.0086 * palm) @ X[:3, :3].T
    assert tips[:4, 2].mean() == pytest.approx(tips[4, 2], abs=1e-3)


@pytest.mark.parametrize("time", [0, 20, 40, 64])
def test_the_lowest_point_of_a_collecting_hand_stays_over_the_table(hand, time):
    motion = collect_motion(hand, SETTINGS)
    X = collect_pose(hand, hand.lower, SETTINGS) @ np.vstack([motion.X_H0H[time], [0, 0, 0, 1]])
    centers, radii = hand.spheres(motion.angles[time])
    heights = centers @ X[2, :3] + X[2, 3] - radii
    assert heights.min() == pytest.approx(SETTINGS.clearance_m, abs=1e-9)


def test_the_power_tcp_of_a_collecting_hand_stays_over_its_place(hand):
    motion = collect_motion(hand, SETTINGS)
    start = collect_pose(hand, hand.lower, SETTINGS)
    tcp = np.append(hand.description.tcps["power"], 1.0)
    places = np.array([(start[:3] @ np.vstack([X, [0, 0, 0, 1]]) @ tcp) for X in motion.X_H0H[::4]])
    np.testing.assert_allclose(places[:, :2], 0, atol=1e-9)


def test_fingers_are_half_closed_when_the_thumb_sets_out(hand):
    motion = collect_motion(hand, SETTINGS)
    expected = hand.joint_angles(hand.motor_fractions(0.5, 0.2))
    np.testing.assert_allclose(motion.angles[32], expected)


def test_the_hand_stands_still_in_a_side_grasp(hand):
    motion = side_motion(hand)
    assert not motion.moving
    np.testing.assert_allclose(motion.angles[-1], hand.upper)
