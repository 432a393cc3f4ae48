import numpy as np
import pytest
from scipy.linalg import expm, logm
from scipy.spatial.transform import Rotation

from vh_drake.control.cartesian_position import cartesian_position_velocity, pose_error
from vh_drake.errors import BadInput


def random_pose(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    X = np.eye(4)
    X[:3, :3] = Rotation.random(rng=rng).as_matrix()
    X[:3, 3] = rng.normal(size=3)
    return X


def skew(v: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


@pytest.mark.parametrize("seed", range(5))
def test_angular_error_is_the_matrix_logarithm(seed):
    X, Y = random_pose(seed), random_pose(seed + 100)
    logarithm = np.real(logm(Y[:3, :3] @ X[:3, :3].T))
    expected = [logarithm[2, 1], logarithm[0, 2], logarithm[1, 0]]
    np.testing.assert_allclose(pose_error(Y, X)[:3], expected, atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 1.0, np.pi - 1e-7, np.pi])
def test_angular_error_turns_the_pose_to_its_target_at_every_angle(angle):
    axis = np.array([2.0, -1.0, 0.5]) / np.linalg.norm([2.0, -1.0, 0.5])
    X, Y = random_pose(1), random_pose(1)
    Y[:3, :3] = expm(angle * skew(axis)) @ X[:3, :3]
    error = pose_error(Y, X)[:3]
    assert np.linalg.norm(error) == pytest.approx(angle, abs=1e-9)
    np.testing.assert_allclose(expm(skew(error)) @ X[:3, :3], Y[:3, :3], atol=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_velocity_keeps_its_bounds_and_points_along_the_error(seed):
    X, Y = random_pose(seed), random_pose(seed + 50)
    velocity = cartesian_position_velocity(Y, X, max_angular_rad_s=0.7, max_linear_m_s=0.2)
    assert np.linalg.norm(velocity[:3]) <= 0.7 + 1e-12
    assert np.linalg.norm(velocity[3:]) <= 0.2 + 1e-12
    error = pose_error(Y, X)
    cosine = velocity @ error / np.linalg.norm(velocity) / np.linalg.norm(error)
    assert cosine == pytest.approx(1.0)


def test_velocity_is_proportional_near_the_target_and_zero_at_it():
    X = random_pose(3)
    Y = X.copy()
    Y[0, 3] += 0.001
    velocity = cartesian_position_velocity(Y, X, gain_per_s=4.0)
    np.testing.assert_allclose(velocity, [0, 0, 0, 0.004, 0, 0], atol=1e-9)
    np.testing.assert_allclose(cartesian_position_velocity(X, X), 0.0, atol=1e-12)


def test_rotating_both_poses_rotates_the_velocity():
    X, Y, turn = random_pose(4), random_pose(5), random_pose(6)
    turn[:3, 3] = 0.0
    expected = cartesian_position_velocity(Y, X).reshape(2, 3) @ turn[:3, :3].T
    velocity = cartesian_position_velocity(turn @ Y, turn @ X)
    np.testing.assert_allclose(velocity.reshape(2, 3), expected, atol=1e-9)


@pytest.mark.parametrize("bad", [np.eye(3), np.full((4, 4), np.nan)])
def test_a_pose_of_wrong_shape_or_with_nan_is_refused(bad):
    with pytest.raises(BadInput, match="shape"):
        cartesian_position_velocity(bad, np.eye(4))
