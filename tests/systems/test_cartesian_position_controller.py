import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw

from vh_drake.control.cartesian_position import (
    GAIN_PER_S,
    MAX_ANGULAR_RAD_S,
    MAX_LINEAR_M_S,
    cartesian_position_velocity,
)
from vh_drake.systems.cartesian_position_controller import CartesianPositionController

HAND = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [0.5, -0.4, 1.1])
TARGET = RigidTransform(RollPitchYaw(0.4, 0.1, -0.5), [0.7, -0.3, 1.0])


def evaluate(system, target: RigidTransform, *, caching: bool = True) -> np.ndarray:
    context = system.CreateDefaultContext()
    if not caching:
        context.DisableCaching()
    system.GetInputPort("target_pose").FixValue(context, Value(target))
    system.GetInputPort("hand_pose").FixValue(context, Value(HAND))
    return system.GetOutputPort("spatial_velocity").Eval(context)


@pytest.mark.parametrize("caching", [True, False])
def test_velocity_is_the_algorithms_with_the_systems_bounds(caching):
    bounds = {"gain_per_s": 2.0, "max_angular_rad_s": 0.5, "max_linear_m_s": 0.1}
    system = CartesianPositionController(**bounds)
    expected = cartesian_position_velocity(TARGET.GetAsMatrix4(), HAND.GetAsMatrix4(), **bounds)
    np.testing.assert_array_equal(evaluate(system, TARGET, caching=caching), expected)


def test_two_contexts_do_not_touch_each_other():
    system = CartesianPositionController()
    moving, resting = evaluate(system, TARGET), evaluate(system, HAND)
    assert np.linalg.norm(moving) > 0.1
    np.testing.assert_allclose(resting, 0.0, atol=1e-12)


def test_new_target_in_the_same_context_is_followed():
    system = CartesianPositionController()
    context = system.CreateDefaultContext()
    system.GetInputPort("hand_pose").FixValue(context, Value(HAND))
    target = system.GetInputPort("target_pose").FixValue(context, Value(TARGET))
    before = system.GetOutputPort("spatial_velocity").Eval(context).copy()
    target.GetMutableData().set_value(HAND)
    after = system.GetOutputPort("spatial_velocity").Eval(context)
    assert np.linalg.norm(before) > 0.1
    np.testing.assert_allclose(after, 0.0, atol=1e-12)


@pytest.mark.parametrize("told", [True, False])
def test_a_hand_that_is_told_how_its_target_moves_does_not_lag(told):
    speed, step, time = 0.05, 0.005, 3.0
    system = CartesianPositionController()
    context = system.CreateDefaultContext()
    target = system.GetInputPort("target_pose").FixValue(context, Value(HAND))
    hand = system.GetInputPort("hand_pose").FixValue(context, Value(HAND))
    if told:
        velocity = [0.0, 0.0, 0.0, speed, 0.0, 0.0]
        system.GetInputPort("target_velocity").FixValue(context, velocity)
    here, there = HAND.translation(), HAND.translation()
    for _ in range(int(time / step)):
        here = here + step * system.GetOutputPort("spatial_velocity").Eval(context)[3:]
        there = there + np.array([step * speed, 0.0, 0.0])
        hand.GetMutableData().set_value(RigidTransform(HAND.rotation(), here))
        target.GetMutableData().set_value(RigidTransform(HAND.rotation(), there))
    lag = 0.0 if told else speed / GAIN_PER_S
    np.testing.assert_allclose(there - here, [lag, 0.0, 0.0], atol=1e-4)


def test_the_velocity_of_the_target_does_not_break_the_bounds():
    system = CartesianPositionController()
    context = system.CreateDefaultContext()
    system.GetInputPort("target_pose").FixValue(context, Value(TARGET))
    system.GetInputPort("hand_pose").FixValue(context, Value(HAND))
    system.GetInputPort("target_velocity").FixValue(context, [9.0, 0, 0, 3.0, 0, 0])
    velocity = system.GetOutputPort("spatial_velocity").Eval(context)
    assert np.linalg.norm(velocity[:3]) <= MAX_ANGULAR_RAD_S + 1e-12
    assert np.linalg.norm(velocity[3:]) <= MAX_LINEAR_M_S + 1e-12
