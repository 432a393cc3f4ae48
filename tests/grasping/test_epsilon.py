import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.grasping.epsilon import epsilon_quality
from vh_drake.grasping.wrench_space import (
    ContactSettings,
    is_force_closure,
    wrench_matrix,
    wrench_quality,
)


def on_ball(rng, count):
    n = rng.normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return wrenches(0.04 * n, n)


def on_box(rng, count):
    half, axis = np.array([0.03, 0.05, 0.09]), rng.integers(3, size=count)
    n, p = np.zeros((count, 3)), rng.uniform(-1, 1, (count, 3)) * half
    n[np.arange(count), axis] = rng.choice([-1.0, 1.0], size=count)
    p[np.arange(count), axis] = (n * half)[np.arange(count), axis]
    return wrenches(p, n)


def wrenches(p, n):
    return wrench_matrix(p, n, center=np.zeros(3), size_m=0.05, settings=ContactSettings())


@pytest.mark.parametrize("draw", [on_ball, on_box])
def test_it_equals_the_nearest_facet_of_the_whole_hull(draw):
    rng = np.random.default_rng(0)
    closed = 0
    for _ in range(60):
        W = draw(rng, int(rng.integers(3, 12)))
        closed += is_force_closure(W)
        assert epsilon_quality(W) == pytest.approx(wrench_quality(W).epsilon, abs=1e-12)
    assert closed > 20


def test_a_cross_polytope_has_the_radius_of_its_ball():
    W = np.hstack([np.eye(6), -np.eye(6)])
    assert epsilon_quality(W) == pytest.approx(1 / np.sqrt(6), abs=1e-14)
    assert epsilon_quality(np.hstack([W, W])) == pytest.approx(1 / np.sqrt(6), abs=1e-14)


def test_it_does_not_change_under_rotation_and_grows_with_the_wrenches():
    W = on_box(np.random.default_rng(3), 9)
    turned = np.kron(np.eye(2), Rotation.random(random_state=1).as_matrix()) @ W
    assert epsilon_quality(W) > 0
    assert epsilon_quality(turned) == pytest.approx(epsilon_quality(W), rel=1e-9)
    assert epsilon_quality(1e-3 * W) == pytest.approx(1e-3 * epsilon_quality(W), rel=1e-9)


def test_an_open_or_a_flat_grasp_has_none():
    assert epsilon_quality(wrenches(0.05 * np.eye(3)[:2], np.eye(3)[:2])) == 0
    flat = np.vstack([np.random.default_rng(0).normal(size=(5, 40)), np.zeros((1, 40))])
    assert epsilon_quality(flat) == 0
    assert epsilon_quality(np.zeros((6, 0))) == 0


def test_more_wrenches_than_it_can_number_are_refused():
    with pytest.raises(BadInput, match="1024 wrenches"):
        epsilon_quality(np.ones((6, 1024)))
