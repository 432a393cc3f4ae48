import numpy as np
import pytest

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.systems.nullspace_controller import NullspaceController

VELOCITY = np.linspace(-0.2, 0.2, 8)


@pytest.fixture(scope="module")
def arm() -> ArmKinematics:
    return ArmKinematics()


def evaluate(system, q, *, caching: bool = True) -> np.ndarray:
    context = system.CreateDefaultContext()
    if not caching:
        context.DisableCaching()
    system.GetInputPort("joint_state").FixValue(context, np.concatenate([q, np.zeros(8)]))
    system.GetInputPort("joint_velocity").FixValue(context, VELOCITY)
    return system.GetOutputPort("joint_velocity").Eval(context)


def near_the_lower_limits(arm: ArmKinematics) -> np.ndarray:
    return 0.9 * arm.lower + 0.1 * arm.upper


@pytest.mark.parametrize("caching", [True, False])
def test_hand_does_not_notice_the_avoidance(arm, caching):
    q = near_the_lower_limits(arm)
    theta = evaluate(NullspaceController(arm), q, caching=caching)
    assert np.linalg.norm(theta - VELOCITY) > 0.1
    np.testing.assert_allclose(arm.jacobian(q) @ (theta - VELOCITY), 0.0, atol=1e-9)


def test_avoidance_raises_the_joints_from_their_lower_limits(arm):
    theta = evaluate(NullspaceController(arm), near_the_lower_limits(arm))
    assert np.sum(theta - VELOCITY) > 0.0


def test_without_gain_the_joint_velocities_pass_unchanged(arm):
    theta = evaluate(NullspaceController(arm, gain=0.0), near_the_lower_limits(arm))
    np.testing.assert_array_equal(theta, VELOCITY)


def test_two_contexts_do_not_touch_each_other(arm):
    system = NullspaceController(arm)
    first = evaluate(system, near_the_lower_limits(arm))
    evaluate(system, arm.home)
    np.testing.assert_array_equal(evaluate(system, near_the_lower_limits(arm)), first)
