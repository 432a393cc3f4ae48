import numpy as np
import pytest
from scipy.linalg import null_space

from vh_drake.control.null_space import (
    add_null_space_velocity,
    limit_avoidance,
    null_space_basis,
    null_space_velocity,
)

LOWER, UPPER = np.linspace(-2.0, -1.0, 8), np.linspace(1.0, 3.0, 8)


def random_problem(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(6, 8)), rng.uniform(LOWER, UPPER)


def test_basis_is_orthonormal_and_leaves_the_hand_still():
    J, _ = random_problem(1)
    N = null_space_basis(J)
    assert N.shape == (8, 2)
    np.testing.assert_allclose(N.T @ N, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(J @ N, 0.0, atol=1e-12)


def test_basis_spans_what_scipy_finds_in_a_singular_posture_too():
    J, _ = random_problem(2)
    J[5] = J[4]
    N, peer = null_space_basis(J), null_space(J)
    assert N.shape == (8, 3)
    np.testing.assert_allclose(N @ N.T, peer @ peer.T, atol=1e-9)


def test_avoidance_is_one_at_the_lower_zero_in_the_middle_minus_one_at_the_upper_limit():
    np.testing.assert_allclose(limit_avoidance(LOWER, LOWER, UPPER), 1.0)
    np.testing.assert_allclose(limit_avoidance((LOWER + UPPER) / 2, LOWER, UPPER), 0.0, atol=1e-15)
    np.testing.assert_allclose(limit_avoidance(UPPER, LOWER, UPPER), -1.0)


def test_null_space_velocity_is_the_nearest_to_the_avoidance_that_leaves_the_hand_still():
    J, q = random_problem(3)
    avoidance = limit_avoidance(q, LOWER, UPPER)
    expected = avoidance - np.linalg.pinv(J) @ (J @ avoidance)
    np.testing.assert_allclose(null_space_velocity(J, q, LOWER, UPPER), expected, atol=1e-9)


@pytest.mark.parametrize("gain", [1.0, 1.5, 2.0])
def test_adding_the_avoidance_keeps_the_hands_velocity(gain):
    J, q = random_problem(4)
    velocity = np.random.default_rng(0).normal(size=8)
    total = add_null_space_velocity(
        velocity, J, q, lower=LOWER, upper=UPPER, velocity_limits=np.full(8, 10.0), gain=gain
    )
    np.testing.assert_allclose(J @ total, J @ velocity, atol=1e-9)
    np.testing.assert_allclose(
        total - velocity, gain * null_space_velocity(J, q, LOWER, UPPER), atol=1e-12
    )


@pytest.mark.parametrize("seed", range(5))
def test_the_sum_keeps_the_velocity_limits_where_the_joint_velocities_do(seed):
    J, q = random_problem(seed)
    limits = np.full(8, 0.8)
    velocity = np.random.default_rng(seed).uniform(-limits, limits)
    total = add_null_space_velocity(
        velocity, J, q, lower=LOWER, upper=UPPER, velocity_limits=limits
    )
    assert np.all(np.abs(total) <= limits + 1e-12)
    np.testing.assert_allclose(J @ total, J @ velocity, atol=1e-9)


def test_avoidance_never_pushes_a_joint_out_of_its_range():
    held = 0
    for seed in range(50):
        J, q = random_problem(seed)
        q[seed % 8] = UPPER[seed % 8]
        addition = add_null_space_velocity(
            np.zeros(8), J, q, lower=LOWER, upper=UPPER, velocity_limits=np.full(8, 10.0)
        )
        plain = null_space_velocity(J, q, LOWER, UPPER)
        held += plain[seed % 8] > 1e-6
        assert addition[seed % 8] <= 1e-12
        np.testing.assert_allclose(J @ addition, 0.0, atol=1e-9)
    assert held > 0  # the plain projection does push some of them


@pytest.mark.parametrize("weakest", [1e-6, 0.02, 0.0499, 0.0501, 0.3])
def test_the_null_space_part_is_the_projection_faded_out_by_the_weakest_singular_value(weakest):
    rng = np.random.default_rng(7)
    U, _, Vt = np.linalg.svd(rng.standard_normal((6, 8)))
    J = U @ np.diag([2.0, 1.5, 1.0, 0.7, 0.5, weakest]) @ Vt[:6]
    q, lower, upper = rng.uniform(-1.0, 1.0, 8), np.full(8, -2.0), np.full(8, 2.0)
    wanted = np.cos(np.pi * (q - lower) / (upper - lower))
    expected = min(weakest / 0.05, 1.0) ** 2 * Vt[6:].T @ (Vt[6:] @ wanted)
    found = null_space_velocity(J, q, lower, upper)
    np.testing.assert_allclose(found, expected, atol=1e-11)
