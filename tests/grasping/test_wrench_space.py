import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.grasping.wrench_space import (
    ContactSettings,
    is_force_closure,
    wrench_matrix,
    wrench_quality,
)

SETTINGS = ContactSettings()
AXES = np.vstack([np.eye(3), -np.eye(3)])


def wrenches(p, n, **changes):
    settings = ContactSettings(**changes)
    return wrench_matrix(p, n, center=np.zeros(3), size_m=0.05, settings=settings)


def random_grasp(rng):
    p = rng.normal(size=(rng.integers(3, 9), 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    n = p + 0.5 * rng.normal(size=p.shape)
    return 0.05 * p, n / np.linalg.norm(n, axis=1, keepdims=True)


def slack(W):
    """The largest weight that all wrenches can have at least in a balance of unit sum, times n.

    Positive iff the origin is strictly inside the hull, where W has full rank.
    """
    n = W.shape[1]
    solution = linprog(
        np.append(np.zeros(n), -1),
        A_eq=np.vstack([np.column_stack([W, np.zeros(6)]), np.append(np.ones(n), 0)]),
        b_eq=np.append(np.zeros(6), 1),
        A_ub=np.column_stack([-np.eye(n), np.ones(n)]),
        b_ub=np.zeros(n),
        bounds=(None, None),
    )
    return -solution.fun * n


def test_force_closure_agrees_with_a_linear_program():
    rng = np.random.default_rng(0)
    grasps = [wrenches(*random_grasp(rng)) for _ in range(150)]
    slacks = np.array([slack(W) for W in grasps])
    clear = np.abs(slacks) > 1e-4
    ours = np.array([is_force_closure(W) for W in grasps])
    assert 0.2 < ours.mean() < 0.95
    np.testing.assert_array_equal(ours[clear], (slacks > 0)[clear])


def test_contacts_all_around_a_ball_are_force_closed():
    assert is_force_closure(wrenches(0.05 * AXES, AXES))


def test_frictionless_contacts_can_not_turn_a_ball():
    assert not is_force_closure(wrenches(0.05 * AXES, AXES, friction=0.0))


def test_two_contacts_can_not_resist_a_turn_about_their_line():
    assert not is_force_closure(wrenches(0.05 * AXES[[0, 3]], AXES[[0, 3]]))


def test_three_contacts_close_a_ball_only_beyond_the_least_friction():
    angles = 2 * np.pi * np.arange(3) / 3
    n = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    assert is_force_closure(wrenches(0.05 * n, n, friction=0.1))
    n_up = (n + np.array([0, 0, 0.5])) / np.linalg.norm(
        [1, 0, 0.5]
    )  # All push down: needs μ > 0.5.
    assert not is_force_closure(wrenches(0.05 * n, n_up, friction=0.4, edges=16))
    assert is_force_closure(wrenches(0.05 * n, n_up, friction=0.7, edges=16))


def test_no_contacts_are_not_force_closed():
    assert not is_force_closure(wrenches(np.zeros((0, 3)), np.zeros((0, 3))))


def test_force_closure_and_quality_do_not_change_under_rotation():
    rng = np.random.default_rng(1)
    R = Rotation.random(random_state=1).as_matrix()
    turned = np.kron(np.eye(2), R)
    for _ in range(5):
        W = wrenches(*random_grasp(rng))
        assert is_force_closure(turned @ W) == is_force_closure(W)
        before, after = wrench_quality(W), wrench_quality(turned @ W)
        assert after.epsilon == pytest.approx(before.epsilon, abs=1e-9)
        assert after.volume == pytest.approx(before.volume, rel=1e-6)


def test_wrenches_do_not_change_when_object_and_size_grow_alike():
    p, n = random_grasp(np.random.default_rng(2))
    larger = wrench_matrix(3 * p, n, center=np.zeros(3), size_m=0.15, settings=SETTINGS)
    np.testing.assert_allclose(larger, wrenches(p, n), atol=1e-12)


def test_each_wrench_lies_on_its_friction_cone():
    p, n = random_grasp(np.random.default_rng(3))
    W = wrenches(p, n, friction=0.6, edges=5)
    normals, points = np.repeat(n, 5, axis=0), np.repeat(p, 5, axis=0)
    pressing = -(W[:3].T * normals).sum(axis=1)
    np.testing.assert_allclose(pressing, 1, atol=1e-12)
    sideways = W[:3].T + normals
    np.testing.assert_allclose(np.linalg.norm(sideways, axis=1), 0.6, atol=1e-12)
    np.testing.assert_allclose(W[3:].T, np.cross(points / 0.05, W[:3].T), atol=1e-12)


def test_epsilon_is_the_radius_of_the_ball_in_a_cross_polytope():
    W = np.hstack([np.eye(6), -np.eye(6)])
    quality = wrench_quality(W)
    assert quality.epsilon == pytest.approx(1 / np.sqrt(6))
    assert quality.volume == pytest.approx(2**6 / 720)


def test_an_open_grasp_has_no_quality():
    quality = wrench_quality(wrenches(0.05 * AXES[:2], AXES[:2]))
    assert (quality.epsilon, quality.volume) == (0, 0)


@pytest.mark.parametrize("settings", [ContactSettings(friction=-0.1), ContactSettings(edges=2)])
def test_unusable_contact_settings_are_refused(settings):
    with pytest.raises(BadInput, match="friction"):
        wrench_matrix(AXES, AXES, center=np.zeros(3), size_m=0.05, settings=settings)


def test_an_object_without_size_is_refused():
    with pytest.raises(BadInput, match="size"):
        wrench_matrix(AXES, AXES, center=np.zeros(3), size_m=0.0, settings=SETTINGS)
