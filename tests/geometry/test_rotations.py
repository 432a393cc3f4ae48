import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vh_drake.geometry.rotations import axis_rotation, between, rotation_vector

X, Y, Z = np.eye(3)


def pose(rng):
    X_WA = np.eye(4)
    X_WA[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    X_WA[:3, 3] = rng.standard_normal(3)
    return X_WA


def test_a_rotation_about_an_axis_agrees_with_scipy():
    rng = np.random.default_rng(0)
    for _ in range(20):
        axis = rng.standard_normal(3)
        axis /= np.linalg.norm(axis)
        angle = rng.uniform(-4.0, 4.0)
        expected = Rotation.from_rotvec(angle * axis).as_matrix()
        np.testing.assert_allclose(axis_rotation(axis, angle), expected, atol=1e-12)


def test_rotation_vectors_agree_with_scipy_up_to_half_a_turn():
    rng = np.random.default_rng(1)
    for _ in range(50):
        R = Rotation.random(random_state=rng)
        np.testing.assert_allclose(rotation_vector(R.as_matrix()), R.as_rotvec(), atol=1e-9)


@pytest.mark.parametrize("axis", [X, Y, Z])
def test_half_a_turn_has_a_vector_of_its_length(axis):
    vector = rotation_vector(axis_rotation(axis, np.pi))
    np.testing.assert_allclose(np.abs(vector), np.pi * axis, atol=1e-9)


def test_no_rotation_has_no_vector():
    np.testing.assert_array_equal(rotation_vector(np.eye(3)), 0.0)


def test_a_pose_between_two_moves_with_a_rigid_motion_of_both():
    rng = np.random.default_rng(2)
    A, B, G = pose(rng), pose(rng), pose(rng)
    np.testing.assert_allclose(between(A, B, 0.0), A, atol=1e-12)
    np.testing.assert_allclose(between(A, B, 1.0), B, atol=1e-12)
    np.testing.assert_allclose(between(G @ A, G @ B, 0.3), G @ between(A, B, 0.3), atol=1e-12)


def test_a_pose_between_two_that_only_shift_does_not_turn():
    A = pose(np.random.default_rng(3))
    B = A.copy()
    B[:3, 3] += [1.0, 2.0, 3.0]
    half = between(A, B, 0.5)
    np.testing.assert_allclose(half[:3, :3], A[:3, :3], atol=1e-12)
    np.testing.assert_allclose(half[:3, 3], A[:3, 3] + [0.5, 1.0, 1.5])
