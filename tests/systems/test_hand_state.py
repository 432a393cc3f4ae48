import numpy as np
import pytest
from leaf import Leaf

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.systems.hand_state import HandState

KINEMATICS = ArmKinematics("right")
RNG = np.random.default_rng(3)
Q = KINEMATICS.home + RNG.uniform(-0.3, 0.3, 8)
V = RNG.uniform(-1, 1, 8)


def hand(q, v=V, caching=True):
    return Leaf(HandState(KINEMATICS), caching=caching, joint_state=np.concatenate([q, v]))


@pytest.mark.parametrize("caching", [True, False])
def test_the_hand_s_velocity_is_that_of_its_poses(caching):
    dt = 1e-6
    before, after = (hand(Q + t * V).get("hand_pose") for t in (-dt, dt))
    velocity = hand(Q, caching=caching).get("hand_velocity")
    moved = (after.translation() - before.translation()) / (2 * dt)
    np.testing.assert_allclose(velocity[3:], moved, atol=1e-7)
    spin = (after.rotation() @ before.rotation().inverse()).ToAngleAxis()
    np.testing.assert_allclose(velocity[:3], spin.angle() * spin.axis() / (2 * dt), atol=1e-5)


@pytest.mark.parametrize("caching", [True, False])
def test_the_hand_s_acceleration_is_that_of_its_velocities(caching):
    dt, A = 1e-6, RNG.uniform(-3, 3, 8)
    states = [np.concatenate([Q + t * V, V + t * A]) for t in (-dt, dt)]
    before, after = (
        Leaf(HandState(KINEMATICS), joint_state=x).get("hand_velocity") for x in states
    )
    leaf = hand(Q, caching=caching)
    leaf.fix(joint_acceleration=A)
    np.testing.assert_allclose(
        leaf.get("hand_acceleration"), (after - before) / (2 * dt), rtol=1e-6, atol=1e-6
    )


def test_a_context_follows_its_own_joints():
    leaf = hand(Q)
    here = leaf.get("hand_pose").GetAsMatrix4()
    elsewhere = Leaf(leaf.system, joint_state=np.zeros(16)).get("hand_pose").GetAsMatrix4()
    assert not np.allclose(here, elsewhere)
    np.testing.assert_allclose(here, KINEMATICS.pose(Q), atol=1e-12)
    leaf.fix(joint_state=np.zeros(16))
    np.testing.assert_allclose(leaf.get("hand_pose").GetAsMatrix4(), elsewhere, atol=1e-12)
