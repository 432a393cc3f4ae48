import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.grasping.closing import close_hand
from vh_drake.grasping.closure_rate import (
    PerturbationSettings,
    closure_rates,
    disturb,
    succession_error,
)
from vh_drake.grasping.field import object_field
from vh_drake.grasping.motions import side_motion
from vh_drake.grasping.wrench_space import ContactSettings, is_force_closure, wrench_matrix
from vh_drake.types import Plane

CONTACT = ContactSettings()
STILL = PerturbationSettings(position_std_m=0, rotation_std_deg=0, min_samples=4, max_samples=4)


@pytest.fixture(scope="module")
def can(standing):
    surface = standing(trimesh.creation.cylinder(0.033, 0.12).subdivide(), x=-0.065, y=0.02)
    return object_field(surface, Plane(np.array([0.0, 0, 1]), 0.0))


@pytest.fixture(scope="module")
def poses(can):
    """Palm towards +x, thumb up, at several distances from the can."""
    X = np.tile(np.eye(4), (6, 1, 1))
    X[:, :3, :3] = np.column_stack([[-1, 0, 0], [0, 0, -1], [0, -1, 0]])
    X[:, :3, 3] = can.center + np.array([-0.045, 0.03, 0.0])
    X[:, 0, 3] -= np.linspace(0, 0.15, 6)
    return X


def rates(hand, can, poses, settings, seed=0):
    return closure_rates(
        hand, can, side_motion(hand), poses, perturbation=settings, contact=CONTACT, seed=seed
    )


def test_without_disturbance_the_rate_is_the_force_closure_of_the_contacts(hand, can, poses):
    expected = []
    for X in poses:
        closure = close_hand(hand, can, side_motion(hand), X)
        W = wrench_matrix(
            closure.p_WC, closure.n_WC, center=can.center, size_m=can.size_m, settings=CONTACT
        )
        expected.append(closure.started_free and is_force_closure(W))
    result = rates(hand, can, poses, STILL)
    np.testing.assert_array_equal(result.rate, np.array(expected, float))
    assert 0 < sum(expected) < len(expected)


def test_the_same_seed_gives_the_same_rates(hand, can, poses):
    one, other = (rates(hand, can, poses, PerturbationSettings(), seed=3) for _ in range(2))
    np.testing.assert_array_equal(one.rate, other.rate)
    np.testing.assert_array_equal(one.centroid, other.centroid)


def test_sampling_stops_once_the_error_is_small_enough(hand, can, poses):
    settings = PerturbationSettings(min_samples=10, max_samples=60, target_error=0.06)
    result = rates(hand, can, poses, settings)
    stopped = result.samples < 60
    assert (result.samples >= 10).all()
    assert (result.standard_error[stopped] <= 0.06).all()
    assert stopped.any()


def test_a_hand_that_misses_the_object_has_rate_0(hand, can, poses):
    result = rates(hand, can, poses[-1:], PerturbationSettings())
    assert result.rate[0] == 0
    assert result.fingers[0] == 0


def test_a_grasp_around_the_can_is_opposed_by_the_thumb_near_the_middle(hand, can, poses):
    result = rates(hand, can, poses[:1], PerturbationSettings())
    assert result.opposed[0] > 0.7
    assert result.fingers[0] > 2
    assert np.linalg.norm(result.centroid[0] - can.center) < 0.04


def test_the_standard_error_is_that_of_repeated_draws():
    rng = np.random.default_rng(0)
    shares = rng.binomial(100, 0.3, 2000) / 100
    assert succession_error(np.array([30.0]), np.array([100.0]))[0] == pytest.approx(
        shares.std(), rel=0.1
    )


def test_disturbances_turn_the_hand_about_its_tcp():
    X = np.eye(4)
    X[:3, :3] = Rotation.random(random_state=1).as_matrix()
    X[:3, 3] = [0.1, 0.2, 0.3]
    tcp, noise = np.array([0.02, -0.01, 0.05]), np.array([0.01, 0.02, -0.01, 0.2, -0.3, 0.1])
    result = np.empty((3, 4))
    disturb(np.ascontiguousarray(X[:3]), tcp, noise, result)
    turn = Rotation.from_rotvec(noise[3:]).as_matrix()
    np.testing.assert_allclose(result[:, :3], X[:3, :3] @ turn, atol=1e-12)
    moved = result[:, :3] @ tcp + result[:, 3]
    np.testing.assert_allclose(moved, X[:3, :3] @ (tcp + noise[:3]) + X[:3, 3], atol=1e-12)


@pytest.mark.parametrize(
    "settings",
    [PerturbationSettings(min_samples=0), PerturbationSettings(position_std_m=-1)],
)
def test_unusable_perturbations_are_refused(hand, can, poses, settings):
    with pytest.raises(BadInput, match="perturbation"):
        rates(hand, can, poses, settings)
