import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, DiagramBuilder, LeafSystem

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.reach import rollout
from vh_drake.errors import BadInput
from vh_drake.systems.cartesian_position_controller import CartesianPositionController
from vh_drake.systems.cartesian_velocity_controller import CartesianVelocityController
from vh_drake.systems.joint_velocity_integrator import JointVelocityIntegrator
from vh_drake.systems.nullspace_controller import NullspaceController


@pytest.fixture(scope="module")
def arm() -> ArmKinematics:
    return ArmKinematics()


def run(arm: ArmKinematics, velocity: np.ndarray, duration_s: float, *, caching: bool = True):
    system = JointVelocityIntegrator(arm)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    system.GetInputPort("joint_velocity").FixValue(context, velocity)
    simulator.AdvanceTo(duration_s)
    return system.GetOutputPort("desired_state").Eval(context)


@pytest.mark.parametrize("caching", [True, False])
def test_positions_are_the_integral_of_the_velocity(arm, caching):
    velocity = np.linspace(-0.3, 0.3, 8)
    state = run(arm, velocity, 0.5, caching=caching)
    # Up to 0.3 rad/s it takes 15 ms.
    np.testing.assert_allclose(state[:8], arm.home + 0.5 * velocity, atol=0.014 * 0.3)
    np.testing.assert_allclose(state[8:], velocity, atol=1e-9)


def test_positions_stop_at_the_limits_with_zero_velocity(arm):
    state = run(arm, np.full(8, 50.0), 4.0)
    np.testing.assert_allclose(state[:8], arm.upper, atol=1e-9)
    np.testing.assert_allclose(state[8:], 0.0, atol=1e-9)


def test_two_contexts_do_not_touch_each_other(arm):
    system = JointVelocityIntegrator(arm)
    first, second = system.CreateDefaultContext(), system.CreateDefaultContext()
    system.set_positions(first, (arm.lower + arm.upper) / 2)
    np.testing.assert_array_equal(system.GetOutputPort("desired_state").Eval(second)[:8], arm.home)


@pytest.mark.parametrize("bad", [np.full(8, 99.0), np.zeros(7), np.full(8, np.nan)])
def test_positions_outside_the_limits_are_refused(arm, bad):
    with pytest.raises(BadInput, match="joint positions"):
        JointVelocityIntegrator(arm, bad)


class HandPose(LeafSystem):
    """Forward kinematics of the commanded joints, for the loop below."""

    def __init__(self, arm: ArmKinematics) -> None:
        super().__init__()
        self._arm = arm
        self._state = self.DeclareVectorInputPort("joint_state", BasicVector(16))
        self.DeclareAbstractOutputPort("pose", lambda: Value(RigidTransform()), self._calc)

    def _calc(self, context, output) -> None:
        output.set_value(RigidTransform(self._arm.pose(self._state.Eval(context)[:8])))


def test_the_four_systems_in_a_loop_move_the_arm_as_the_rollout_does(arm):
    X_target = arm.pose(arm.home)
    X_target[:3, 3] += [0.15, 0.1, -0.1]
    builder = DiagramBuilder()
    pose = builder.AddSystem(HandPose(arm))
    position = builder.AddSystem(CartesianPositionController())
    velocity = builder.AddSystem(CartesianVelocityController(arm))
    nullspace = builder.AddSystem(NullspaceController(arm))
    integrator = builder.AddSystem(JointVelocityIntegrator(arm, period_s=0.02))
    desired = integrator.GetOutputPort("desired_state")
    for system in (pose, velocity, nullspace):
        builder.Connect(desired, system.GetInputPort("joint_state"))
    builder.Connect(pose.GetOutputPort("pose"), position.GetInputPort("hand_pose"))
    builder.Connect(position.get_output_port(), velocity.GetInputPort("spatial_velocity"))
    builder.Connect(velocity.get_output_port(), nullspace.GetInputPort("joint_velocity"))
    builder.Connect(nullspace.get_output_port(), integrator.get_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    position.GetInputPort("target_pose").FixValue(
        position.GetMyContextFromRoot(context), Value(RigidTransform(X_target))
    )
    expected = rollout(arm, arm.home, [X_target], dt=0.02)
    simulator.AdvanceTo((len(expected.q) - 1.5) * 0.02)
    q = desired.Eval(integrator.GetMyContextFromRoot(context))[:8]
    assert expected.reached
    np.testing.assert_allclose(q, expected.q[-1], atol=1e-9)
