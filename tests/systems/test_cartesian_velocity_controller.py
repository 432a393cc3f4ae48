import numpy as np
import pytest

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.errors import BadInput
from vh_drake.systems.cartesian_velocity_controller import CartesianVelocityController

VELOCITY = np.array([0.1, -0.2, 0.05, 0.05, 0.1, -0.08])


@pytest.fixture(scope="module")
def arm() -> ArmKinematics:
    return ArmKinematics()


def evaluate(system, velocity, q, *, caching: bool = True) -> np.ndarray:
    context = system.CreateDefaultContext()
    if not caching:
        context.DisableCaching()
    system.GetInputPort("spatial_velocity").FixValue(context, velocity)
    system.GetInputPort("joint_state").FixValue(context, np.concatenate([q, np.zeros(8)]))
    return system.GetOutputPort("joint_velocity").Eval(context)


@pytest.mark.parametrize("caching", [True, False])
def test_joint_velocity_gives_the_hand_its_velocity(arm, caching):
    system = CartesianVelocityController(arm)
    theta = evaluate(system, VELOCITY, arm.home, caching=caching)
    np.testing.assert_allclose(arm.jacobian(arm.home) @ theta, VELOCITY, atol=1e-9)


def test_joint_velocity_keeps_the_arms_limits(arm):
    theta = evaluate(CartesianVelocityController(arm), 100.0 * VELOCITY, arm.home)
    assert np.all(np.abs(theta) <= arm.velocity_limits + 1e-12)


def test_two_contexts_do_not_touch_each_other(arm):
    system = CartesianVelocityController(arm)
    moving, resting = evaluate(system, VELOCITY, arm.home), evaluate(system, np.zeros(6), arm.home)
    assert np.linalg.norm(moving) > 0.01
    np.testing.assert_array_equal(resting, 0.0)


def test_nan_is_refused_before_it_reaches_the_joints(arm):
    with pytest.raises(BadInput, match="finite"):
        evaluate(CartesianVelocityController(arm), VELOCITY * np.nan, arm.home)
