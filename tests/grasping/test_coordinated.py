import itertools

import numpy as np
import pytest

from vh_drake.errors import BadInput, UnknownName
from vh_drake.grasping.coordinated import (
    APPROACHES,
    key_points_for,
    load_coordinated_grasp,
    shipped_grasp,
    tip_gap,
)
from vh_drake.grasping.motions import CollectSettings, collect_pose
from vh_drake.hand.key_points import check_key_points, hand_pose, key_point_at

POINTS = "[{fingers: 0.5, thumb: 0.2}, {fingers: 1, thumb: 1, lift_m: 0.03}]"
ALIVE = f"name: a\napproach: top\nkey_points: {POINTS}\n"


def columns(trajectory):
    return np.array([point.values() for point in trajectory.key_points])


def heights(hand, point):
    """Lowest points of the tips where hand and fingers are in free space at a key point."""
    X_WH0 = collect_pose(hand, hand.lower, CollectSettings(clearance_m=0.0))
    X_WH = hand_pose(point, hand.description, X_WH0)
    tips = hand.tips(hand.joint_angles(hand.motor_fractions(point.fingers, point.thumb)))
    return tips @ X_WH[2, :3] + X_WH[2, 3] - hand.arrays.sphere_radius[hand.tip_spheres]


@pytest.mark.parametrize("approach", APPROACHES)
def test_shipped_trajectories_have_ten_key_points_half_a_second_apart(hand, approach):
    trajectory = key_points_for(shipped_grasp(approach), hand)
    check_key_points(trajectory)
    times = [point.time_s for point in trajectory.key_points]
    np.testing.assert_allclose(times, 0.5 * np.arange(11))
    fingers, thumb = columns(trajectory)[:, :2].T
    assert (fingers[8], thumb[8]) == (0.5, 0.2)
    assert (fingers[9], thumb[9]) == (1.0, 1.0)
    lifted = columns(trajectory)[10] - columns(trajectory)[9]
    np.testing.assert_allclose(lifted, [0, 0, 0, 0, 0.03, 0, 0, 0], atol=1e-9)


def test_from_the_top_the_tips_keep_their_heights_until_the_hand_presses(hand):
    trajectory = key_points_for(shipped_grasp("top"), hand)
    points = [key_point_at(trajectory.key_points, t) for t in np.linspace(0.0, 3.0, 31)]
    closing = np.array([heights(hand, point) for point in points])
    assert np.ptp(closing, axis=0).max() / 2 < 0.005
    assert closing.min() > -5e-4
    up = columns(trajectory)[:, 4]
    assert up[8] < up[6]


def test_from_the_side_the_hand_stands_still_until_it_lifts(hand):
    rows = columns(key_points_for(shipped_grasp("side"), hand))
    np.testing.assert_array_equal(rows[:10, 2:], 0.0)


@pytest.mark.parametrize("size_m", [0.06, 0.08, 0.1])
def test_the_fingers_gather_until_the_tips_are_as_far_apart_as_the_object_is_wide(hand, size_m):
    trajectory = key_points_for(shipped_grasp("top"), hand, size_m)
    gathered = trajectory.key_points[8]
    assert tip_gap(hand, gathered.fingers, gathered.thumb) == pytest.approx(size_m, abs=1e-5)
    points = [key_point_at(trajectory.key_points, t) for t in np.linspace(0.0, 3.0, 31)]
    closing = np.array([heights(hand, point) for point in points])
    assert np.ptp(closing, axis=0).max() / 2 < 0.005
    check_key_points(trajectory)


def test_wider_objects_turn_the_hand_less(hand):
    turns = [
        -columns(key_points_for(shipped_grasp("top"), hand, size))[-1, 6]
        for size in (0.03, 0.06, 0.09, 0.5)
    ]
    assert all(wide < narrow for narrow, wide in itertools.pairwise(turns))


def test_what_the_fingers_do_not_meet_leaves_the_columns_as_they_are(hand):
    grasp = shipped_grasp("top")
    plain = columns(key_points_for(grasp, hand))
    np.testing.assert_array_equal(columns(key_points_for(grasp, hand, 0.01)), plain)


def test_a_size_must_be_positive(hand):
    with pytest.raises(BadInput, match="size"):
        key_points_for(shipped_grasp("top"), hand, 0.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ALIVE.replace("top", "below"), "approach 'below'"),
        (ALIVE.replace("0.2", "1.2"), "thumb is 1.2"),
        (ALIVE.replace("0.03", ".nan"), "lift_m is nan"),
        (ALIVE + "spacing_s: 0\n", "spacing_s is 0"),
        (ALIVE.replace("fingers: 1,", "fingers: 0.9,"), "then enclose"),
        (ALIVE.replace("0.5,", "1,"), "gather first"),
        (ALIVE + "speed: 1\n", "not a valid"),
        ("key_points: 3\n", "not a valid"),
    ],
)
def test_a_file_that_no_hand_can_follow_is_refused(tmp_path, text, message):
    path = tmp_path / "grasp.yaml"
    path.write_text(text)
    with pytest.raises(BadInput, match=message):
        load_coordinated_grasp(path)


def test_a_file_in_order_loads(tmp_path):
    path = tmp_path / "grasp.yaml"
    path.write_text(ALIVE)
    assert load_coordinated_grasp(path).gathered == 2


def test_an_unknown_approach_lists_the_choices():
    with pytest.raises(UnknownName, match="side, top"):
        shipped_grasp("below")
