import numpy as np
import pytest
from leaf import Leaf
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from vh_drake.systems.fingertip import Fingertip

X_HT = RigidTransform(RollPitchYaw(0.3, -0.8, 1.1), [0.02, -0.03, 0.13])
X_WH = RigidTransform(RollPitchYaw(-1.2, 0.4, 2.0), [0.5, -0.4, 1.1])
V_WH = np.array([0.4, -0.7, 0.9, 0.1, 0.05, -0.2])


def tip(caching=True, **inputs):
    given = {"hand_pose": X_WH, "hand_velocity": V_WH, "tip_command": np.zeros(6)}
    return Leaf(Fingertip(X_HT.GetAsMatrix4()), caching=caching, **(given | inputs))


def moved(X, V, dt):
    """The pose after a short time at a spatial velocity in W."""
    angle = np.linalg.norm(V[:3]) * dt
    axis = V[:3] / max(np.linalg.norm(V[:3]), 1e-12)
    turn = RotationMatrix(AngleAxis(angle, axis))
    return RigidTransform(turn @ X.rotation(), X.translation() + dt * V[3:])


@pytest.mark.parametrize("caching", [True, False])
def test_the_tip_is_fixed_in_the_hand(caching):
    pose = tip(caching).get("fingertip_pose")
    assert pose.IsNearlyEqualTo(X_WH @ X_HT, 1e-12)


@pytest.mark.parametrize("caching", [True, False])
def test_the_tip_s_velocity_is_that_of_finite_differences(caching):
    dt = 1e-6
    before, after = (tip(hand_pose=moved(X_WH, V_WH, t)).get("fingertip_pose") for t in (-dt, dt))
    V = tip(caching).get("fingertip_velocity")
    np.testing.assert_allclose(
        V[3:], (after.translation() - before.translation()) / (2 * dt), atol=1e-8
    )
    spin = (after.rotation() @ before.rotation().inverse()).ToAngleAxis()
    np.testing.assert_allclose(V[:3], spin.angle() * spin.axis() / (2 * dt), atol=1e-6)


def test_a_hand_that_does_as_told_moves_the_tip_as_asked():
    wanted = np.array([0.2, 0.5, -0.3, -0.04, 0.01, 0.03])
    command = tip(tip_command=wanted).get("hand_command")
    np.testing.assert_allclose(
        tip(hand_velocity=command).get("fingertip_velocity"), wanted, atol=1e-14
    )


def test_two_contexts_do_not_touch_each_other():
    first = tip()
    velocity = first.get("fingertip_velocity")
    other = Leaf(first.system, hand_pose=RigidTransform(), hand_velocity=2 * V_WH)
    assert not np.allclose(other.get("fingertip_velocity"), velocity)
    np.testing.assert_array_equal(first.get("fingertip_velocity"), velocity)
