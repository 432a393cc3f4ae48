import copy

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vh_drake.hand.program import (
    FAST_M_S,
    FAST_RAD_S,
    Leg,
    MotionProgram,
    interpolate,
    path,
    smooth,
    travel_time,
)

RNG = np.random.default_rng(5)


def pose(p=(0.0, 0.0, 0.0), rotvec=(0.0, 0.0, 0.0)):
    X = np.eye(4)
    X[:3, :3] = Rotation.from_rotvec(rotvec).as_matrix()
    X[:3, 3] = p
    return X


def random_pose():
    return pose(RNG.uniform(-1, 1, 3), RNG.uniform(-1, 1, 3))


def test_interpolation_starts_and_ends_at_the_poses():
    A, B = random_pose(), random_pose()
    np.testing.assert_allclose(interpolate(A, B, 0.0), A, atol=1e-12)
    np.testing.assert_allclose(interpolate(A, B, 1.0), B, atol=1e-12)


def test_interpolated_poses_turn_evenly_on_a_straight_line():
    A, B = random_pose(), random_pose()
    angle = Rotation.from_matrix(A[:3, :3].T @ B[:3, :3]).magnitude()
    for share in (0.2, 0.5, 0.9):
        X = interpolate(A, B, share)
        np.testing.assert_allclose(X[:3, 3], (1 - share) * A[:3, 3] + share * B[:3, 3])
        turned = Rotation.from_matrix(A[:3, :3].T @ X[:3, :3]).magnitude()
        assert turned == pytest.approx(share * angle)
        assert np.linalg.det(X[:3, :3]) == pytest.approx(1.0)


def test_interpolation_moves_with_a_rigid_motion_of_both_ends():
    A, B, G = random_pose(), random_pose(), random_pose()
    np.testing.assert_allclose(
        interpolate(G @ A, G @ B, 0.37), G @ interpolate(A, B, 0.37), atol=1e-12
    )


def test_smooth_time_scaling_starts_and_ends_at_rest():
    assert smooth(0.0) == 0.0
    assert smooth(1.0) == pytest.approx(1.0)
    assert (smooth(-3.0), smooth(7.0)) == (0.0, pytest.approx(1.0))
    h = 1e-4
    for order in (1, 2):  # Velocity and acceleration vanish at both ends.
        for end in (0.0, 1.0):
            inward = h if end == 0.0 else -h
            samples = [smooth(end + i * inward) - smooth(end) for i in range(3)]
            derivative = np.diff(samples, order)[0] / h**order
            assert abs(derivative) < 0.02
    values = [smooth(s) for s in np.linspace(0, 1, 101)]
    assert (np.diff(values) > 0).all()
    assert smooth(0.3) + smooth(0.7) == pytest.approx(1.0)


def test_minimum_jerk_is_the_quintic_between_rests():
    s = np.linspace(0, 1, 9)
    system = [[1, 1, 1], [3, 4, 5], [6, 12, 20]]  # x(1) = 1, x'(1) = 0, x''(1) = 0
    a = np.linalg.solve(system, [1.0, 0.0, 0.0])
    np.testing.assert_allclose([smooth(x) for x in s], a @ [s**3, s**4, s**5], atol=1e-12)


def test_travel_time_is_that_of_the_slower_of_way_and_turn():
    assert travel_time(pose(), pose((0.6, 0, 0))) == pytest.approx(0.6 / FAST_M_S)
    assert travel_time(pose(), pose(rotvec=(0, 0, 3.0))) == pytest.approx(3.0 / FAST_RAD_S)
    assert travel_time(pose(), pose((0.6, 0, 0), (0, 2.0, 0))) == pytest.approx(0.6 / FAST_M_S)
    assert travel_time(pose(), pose()) == pytest.approx(0.2)
    assert travel_time(pose(), pose((0.6, 0, 0)), linear_m_s=0.1) == pytest.approx(6.0)


def test_a_path_s_legs_start_where_the_last_one_ended():
    poses = [random_pose() for _ in range(3)]
    legs = path(pose(), poses, ["a", "b", "c"], np.array([0.1, 0.2]))
    assert [leg.name for leg in legs] == ["a", "b", "c"]
    for leg, before, after in zip(legs, [pose(), *poses], poses, strict=False):
        np.testing.assert_array_equal(leg.X_WH, after)
        assert leg.duration_s == pytest.approx(travel_time(before, after))
        assert not leg.guarded


def test_as_many_names_as_poses_are_needed():
    with pytest.raises(ValueError, match="zip"):
        path(pose(), [pose()], ["a", "b"], np.zeros(2))


def test_a_copy_of_a_program_costs_nothing():
    program = MotionProgram(1, (Leg(), Leg()))
    assert copy.deepcopy(program) is program
