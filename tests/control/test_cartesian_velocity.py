import numpy as np
import pytest

from vh_drake.control.cartesian_velocity import cartesian_velocity_to_joints
from vh_drake.errors import BadInput

FREE = {"lower": np.full(8, -9.0), "upper": np.full(8, 9.0), "velocity_limits": np.full(8, 1e6)}


def random_problem(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=6), rng.normal(size=(6, 8))


def test_joint_velocity_is_the_least_that_gives_the_hand_its_velocity():
    velocity, J = random_problem(1)
    theta = cartesian_velocity_to_joints(velocity, J, np.zeros(8), **FREE)
    np.testing.assert_allclose(theta, np.linalg.pinv(J) @ velocity, atol=1e-9)


def test_velocity_limits_slow_the_hand_and_keep_its_direction():
    velocity, J = random_problem(2)
    limits = FREE | {"velocity_limits": np.full(8, 0.1)}
    theta = cartesian_velocity_to_joints(velocity, J, np.zeros(8), **limits)
    assert np.abs(theta).max() == pytest.approx(0.1)
    moved = J @ theta
    np.testing.assert_allclose(moved / np.linalg.norm(moved), velocity / np.linalg.norm(velocity))


def test_a_joint_at_its_limit_rests_and_the_others_do_its_work():
    velocity, J = random_problem(3)
    free = cartesian_velocity_to_joints(velocity, J, np.zeros(8), **FREE)
    joint = int(np.argmax(np.abs(free)))
    q = np.zeros(8)
    q[joint] = 9.0 * np.sign(free[joint])
    theta = cartesian_velocity_to_joints(velocity, J, q, **FREE)
    assert theta[joint] == 0.0
    np.testing.assert_allclose(J @ theta, velocity, atol=1e-9)


def test_a_joint_at_its_limit_may_move_inward():
    velocity, J = random_problem(4)
    free = cartesian_velocity_to_joints(velocity, J, np.zeros(8), **FREE)
    theta = cartesian_velocity_to_joints(velocity, J, -9.0 * np.sign(free), **FREE)
    np.testing.assert_allclose(theta, free)


@pytest.mark.parametrize("weakest", [0.0, 1e-12, 1e-6, 1e-3])
def test_joints_stay_slow_at_singular_postures(weakest):
    velocity, J = random_problem(5)
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    s[-1] = weakest
    theta = cartesian_velocity_to_joints(velocity, U @ np.diag(s) @ Vt, np.zeros(8), **FREE)
    assert np.abs(theta).max() < 2 * np.linalg.norm(velocity) / s[-2] + 0.5


def test_shapes_that_do_not_fit_and_nan_are_refused():
    velocity, J = random_problem(6)
    with pytest.raises(BadInput, match="do not fit"):
        cartesian_velocity_to_joints(velocity[:5], J, np.zeros(8), **FREE)
    with pytest.raises(BadInput, match="finite"):
        cartesian_velocity_to_joints(velocity * np.nan, J, np.zeros(8), **FREE)
