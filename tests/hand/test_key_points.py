import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RollPitchYaw
from scenery import right_hand
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.hand.key_points import (
    KeyPoint,
    KeyPointTrajectory,
    hand_pose,
    key_point_at,
    load_key_points,
    save_key_points,
    start_axes,
)

HAND = right_hand().description
RNG = np.random.default_rng(3)
P_HP = np.array(HAND.tcps["power"])


def random_pose(rng=RNG):
    X = np.eye(4)
    X[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    X[:3, 3] = rng.uniform(-1, 1, 3)
    return X


def random_points(count):
    times = np.cumsum(RNG.uniform(0.1, 1.0, count))
    return [
        KeyPoint.from_values(t, [*RNG.uniform(0, 1, 2), *RNG.uniform(-0.3, 0.3, 3), *angles])
        for t, angles in zip(times, RNG.uniform(-60, 60, (count, 3)), strict=True)
    ]


def test_a_trajectory_comes_back_from_its_file(tmp_path):
    before = KeyPointTrajectory("press and lift", random_points(7))
    save_key_points(tmp_path / "a.yaml", before)
    after = load_key_points(tmp_path / "a.yaml")
    assert after == before
    save_key_points(tmp_path / "b.yaml", after)
    assert (tmp_path / "a.yaml").read_bytes() == (tmp_path / "b.yaml").read_bytes()


def test_a_file_may_name_only_what_it_changes(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text("key_points: [{}, {time_s: 0.5, rpy_deg: [0, 25, 0]}]\n")
    points = load_key_points(path).key_points
    assert points == [KeyPoint(), KeyPoint(time_s=0.5, rpy_deg=[0.0, 25.0, 0.0])]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("key_points: []", "0 key points"),
        ("key_points: [{time_s: 1}, {time_s: 1}]", "later than the one before"),
        ("key_points: [{fingers: 1.2}]", "key point 0: fingers is 1.2"),
        ("key_points: [{thumb: .nan}]", "thumb is nan"),
        ("key_points: [{position_m: [0, 0]}]", "must be 3 numbers"),
        ("key_points: [{rpy_deg: [0, 200, 0]}]", "from -180 to 180"),
        ("key_points: [{time_s: -1}]", "time_s is -1"),
        ("key_points: [{pitch: 3}]", "not a valid"),
        ("{", "not a valid"),
    ],
)
def test_an_unusable_file_is_named_with_what_is_wrong(text, message, tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(BadInput, match=message) as caught:
        load_key_points(path)
    assert "bad.yaml" in str(caught.value)


def test_what_could_not_be_loaded_is_not_saved(tmp_path):
    with pytest.raises(BadInput, match="fingers is 2"):
        save_key_points(tmp_path / "a.yaml", KeyPointTrajectory("", [KeyPoint(fingers=2.0)]))
    assert not (tmp_path / "a.yaml").exists()


def test_between_key_points_everything_goes_straight():
    points = random_points(4)
    for point in points:
        np.testing.assert_allclose(key_point_at(points, point.time_s).values(), point.values())
    middle = key_point_at(points, (points[1].time_s + points[2].time_s) / 2).values()
    np.testing.assert_allclose(middle, (points[1].values() + points[2].values()) / 2, atol=1e-4)


def test_before_its_start_and_after_its_end_a_trajectory_stands_still():
    points = random_points(3)
    for time_s, end in ((-5.0, points[0]), (100.0, points[-1])):
        np.testing.assert_array_equal(key_point_at(points, time_s).values(), end.values())


def test_a_key_point_at_zero_is_the_start():
    for _ in range(5):
        X_WH0 = random_pose()
        np.testing.assert_allclose(hand_pose(KeyPoint(), HAND, X_WH0), X_WH0, atol=1e-12)


def test_the_axes_are_upright_and_the_fingers_point_forward():
    for _ in range(20):
        X_WH0 = random_pose()
        R_WG = start_axes(HAND, X_WH0)
        np.testing.assert_allclose(R_WG.T @ R_WG, np.eye(3), atol=1e-12)
        assert np.linalg.det(R_WG) == pytest.approx(1.0)
        np.testing.assert_array_equal(R_WG[:, 2], [0, 0, 1])
        fingers = R_WG.T @ X_WH0[:3, :3] @ HAND.along
        if abs(fingers[2]) < 0.99:
            assert fingers[0] > 0
            assert fingers[1] == pytest.approx(0.0, abs=1e-12)


def test_where_the_fingers_point_down_the_palm_faces_forward():
    X_WH0 = np.eye(4)
    X_WH0[:3, :3] = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
    palm = start_axes(HAND, X_WH0).T @ X_WH0[:3, :3] @ HAND.palm
    np.testing.assert_allclose(palm, [1, 0, 0], atol=1e-12)


def test_turns_keep_the_power_tcp_and_a_pitch_lowers_the_fingertips():
    X_WH0 = np.eye(4)
    X_WH0[:3, :3] = np.array([[0.0, 0, 1], [0, -1, 0], [1, 0, 0]])  # fingers along +x, palm down
    pitched = hand_pose(KeyPoint(rpy_deg=[0.0, 25.0, 0.0]), HAND, X_WH0)
    for X in (X_WH0, pitched):
        np.testing.assert_allclose(X[:3, :3] @ P_HP + X[:3, 3], X_WH0[:3, :3] @ P_HP, atol=1e-12)
    tip = np.array([0.03, 0.0, 0.14, 1.0])
    assert (pitched @ tip)[2] < (X_WH0 @ tip)[2] - 0.03


def test_a_pose_turns_and_shifts_with_the_start():
    point = random_points(1)[0]
    X_WH0 = random_pose()
    turned = np.eye(4)
    turned[:3, :3] = RollPitchYaw(0, 0, 0.7).ToRotationMatrix().matrix()
    turned[:3, 3] = [0.1, -0.2, 0.3]
    np.testing.assert_allclose(
        hand_pose(point, HAND, turned @ X_WH0), turned @ hand_pose(point, HAND, X_WH0), atol=1e-12
    )


def test_roll_pitch_and_yaw_are_drake_s():
    point = random_points(1)[0]
    X_WH0 = random_pose()
    R_WG = start_axes(HAND, X_WH0)
    expected = RollPitchYaw(np.deg2rad(point.rpy_deg)).ToRotationMatrix().matrix()
    X_WH = hand_pose(point, HAND, X_WH0)
    np.testing.assert_allclose(R_WG.T @ X_WH[:3, :3] @ X_WH0[:3, :3].T @ R_WG, expected, atol=1e-12)


def test_values_hold_all_but_the_time():
    for point in random_points(3):
        assert KeyPoint.from_values(point.time_s, point.values()) == point
        assert dc.replace(point, time_s=0.0) == KeyPoint.from_values(0.0, point.values())
