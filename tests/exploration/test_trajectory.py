import numpy as np
import pytest
from pydrake.math import RollPitchYaw, RotationMatrix
from scipy.interpolate import BPoly

from vh_drake.errors import BadInput
from vh_drake.exploration.trajectory import (
    aligned,
    approach_curves,
    arc_length,
    closest_parameter,
    orientation,
    position,
    recovery_curve,
    recovery_plan,
    rotation_vector,
    velocity,
)

CURVE = np.array([[0.0, 0, 0], [0.1, 0, 0.2], [0.3, 0.1, 0.2], [0.3, 0.2, 0.0]])
PEER = BPoly(CURVE[:, None, :], [0, 1])


@pytest.mark.parametrize("tau", [0.0, 0.3, 0.77, 1.0])
def test_position_and_velocity_equal_those_of_scipys_bernstein_polynomial(tau):
    np.testing.assert_allclose(position(CURVE, tau), PEER(tau), atol=1e-14)
    np.testing.assert_allclose(velocity(CURVE, tau), PEER(tau, nu=1), atol=1e-13)


def test_curve_goes_straight_on_beyond_its_end():
    np.testing.assert_allclose(
        position(CURVE, 1.5), CURVE[3] + 0.5 * velocity(CURVE, 1.0), atol=1e-14
    )


def test_arc_length_equals_that_of_a_fine_polyline():
    points = PEER(np.linspace(0, 1, 20001))
    polyline = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert arc_length(np.stack([CURVE, CURVE[::-1]])) == pytest.approx([polyline] * 2, rel=1e-6)


def test_approach_meets_the_requirements_of_equation_3_75():
    tip, departure = np.array([0.1, 0.0, 0.3]), np.array([0.0, 0.0, 1.0])
    target, normal = np.array([[0.4, 0.1, 0.2]]), np.array([[0.6, 0.0, 0.8]])
    curve = approach_curves(tip, departure, target, normal)[0]
    k = np.linalg.norm(tip - target[0])
    np.testing.assert_allclose(position(curve, 0.0), tip)
    np.testing.assert_allclose(position(curve, 1.0), target[0])
    np.testing.assert_allclose(velocity(curve, 0.0), k * departure)
    np.testing.assert_allclose(velocity(curve, 1.0), -k * normal[0])


def test_fingertip_at_rest_leaves_towards_the_place_before_the_target():
    curve = approach_curves(np.zeros(3), None, np.array([[0.3, 0, 0]]), np.array([[0, 0, 1.0]]))[0]
    np.testing.assert_allclose(np.cross(velocity(curve, 0.0), curve[2]), 0.0, atol=1e-15)


def test_missed_touch_returns_through_the_surface_to_the_last_contact():
    tip, v = np.array([0.2, 0.0, -0.05]), np.array([0.0, 0.0, -0.03])
    contact, normal = np.zeros(3), np.array([0.0, 0.0, 1.0])
    curve = recovery_curve(tip, v, contact, normal)
    assert velocity(curve, 0.0) @ v == pytest.approx(np.linalg.norm(tip) * 0.03)
    np.testing.assert_allclose(velocity(curve, 1.0), np.linalg.norm(tip) * normal)
    assert position(curve, 0.9) @ normal < 0.0
    plan = recovery_plan(tip, v, contact, normal)
    np.testing.assert_allclose(plan.n_WT, -normal)
    with pytest.raises(BadInput, match="velocity is zero"):
        recovery_curve(tip, np.zeros(3), contact, normal)


def test_closest_parameter_equals_a_dense_search():
    rng = np.random.default_rng(0)
    taus = np.linspace(0, 1, 100001)
    points = PEER(taus)
    for p in rng.uniform(-0.1, 0.25, (20, 3)):
        inside = taus[np.linalg.norm(points - p, axis=1).argmin()]
        found = closest_parameter(CURVE, p)
        if found <= 1.0:
            assert found == pytest.approx(inside, abs=2e-5)


def test_closest_parameter_never_falls_and_passes_the_end():
    assert closest_parameter(CURVE, CURVE[0], tau_from=0.4) >= 0.4
    end = velocity(CURVE, 1.0)
    assert closest_parameter(CURVE, CURVE[3] + 0.25 * end) == pytest.approx(1.25)


@pytest.mark.parametrize("normal", [[0, 0, 1.0], [0, 0, -1.0], [0.6, 0, 0.8]])
def test_aligned_fingertip_lies_against_the_normal(normal):
    start = RotationMatrix(RollPitchYaw(0.3, -0.2, 1.0))
    np.testing.assert_allclose(
        aligned(start, np.array(normal)).col(2), -np.array(normal), atol=1e-9
    )
    same = aligned(start, -start.col(2))
    np.testing.assert_allclose(same.matrix(), start.matrix(), atol=1e-9)
    opposite = aligned(start, start.col(2))
    np.testing.assert_allclose(opposite.col(2), -start.col(2), atol=1e-9)


def test_orientation_turns_uniformly_from_start_to_target():
    R_0, R_1 = RotationMatrix(RollPitchYaw(0.1, 0.2, 0.3)), RotationMatrix(RollPitchYaw(1, -1, 2))
    whole = np.linalg.norm(rotation_vector(R_0.inverse() @ R_1))
    for tau in (0.0, 0.25, 0.5, 1.0):
        turned = np.linalg.norm(rotation_vector(R_0.inverse() @ orientation(R_0, R_1, tau)))
        assert turned == pytest.approx(tau * whole, abs=1e-9)
    np.testing.assert_allclose(orientation(R_0, R_1, 1.7).matrix(), R_1.matrix(), atol=1e-9)
