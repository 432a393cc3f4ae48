import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator

from vh_drake.exploration.follow import FollowSettings, follow
from vh_drake.exploration.trajectory import approach_curves, position
from vh_drake.systems.trajectory_follower import TrajectoryFollower
from vh_drake.types import TouchPlan

SETTINGS = FollowSettings(speed_m_per_s=0.04, missed_after_m=0.01)
START = RigidTransform(RotationMatrix(RollPitchYaw(0.2, 0.1, 0.0)), [0.1, 0.0, 0.3])


def plan(target=(0.4, 0.1, 0.2)):
    target, normal = np.array([target]), np.array([[1.0, 0, 0]])
    up = np.array([0.0, 0, 1.0])
    return TouchPlan(
        target[0], normal[0], approach_curves(START.translation(), up, target, normal)[0]
    )


def fix(system, context, pose, *, enable=1.0, to=None):
    system.GetInputPort("plan").FixValue(context, Value[object](to or plan()))
    system.GetInputPort("fingertip_pose").FixValue(context, Value(pose))
    system.GetInputPort("enable").FixValue(context, [enable])


def outputs(system, context):
    return (
        system.GetOutputPort("spatial_velocity").Eval(context),
        system.GetOutputPort("missed").Eval(context)[0],
    )


@pytest.mark.parametrize("caching", [True, False])
def test_velocity_is_that_of_the_algorithm(caching):
    system = TrajectoryFollower(SETTINGS)
    context = system.CreateDefaultContext()
    if not caching:
        context.DisableCaching()
    fix(system, context, START)
    expected = follow(plan(), START.rotation(), START, tau_from=0.0, settings=SETTINGS)
    np.testing.assert_allclose(outputs(system, context)[0], expected.V_WT, atol=1e-12)
    assert outputs(system, context)[1] == 0.0


def test_disabled_follower_stands_still():
    system = TrajectoryFollower(SETTINGS)
    context = system.CreateDefaultContext()
    fix(system, context, START, enable=0.0)
    np.testing.assert_array_equal(outputs(system, context)[0], np.zeros(6))


def moved_to(system, simulator, p, **options):
    """Put the fingertip somewhere and let the follower look at it."""
    context = simulator.get_mutable_context()
    fix(system, context, RigidTransform(START.rotation(), p), **options)
    simulator.AdvanceTo(context.get_time() + 0.02)
    return outputs(system, context)


def test_place_on_the_curve_never_falls_until_enabled_anew():
    system = TrajectoryFollower(SETTINGS)
    simulator = Simulator(system)
    curve = plan().control_points
    moved_to(system, simulator, position(curve, 0.0))
    moved_to(system, simulator, position(curve, 0.9))
    back, _ = moved_to(system, simulator, position(curve, 0.2))
    late = follow(
        plan(),
        START.rotation(),
        RigidTransform(START.rotation(), position(curve, 0.2)),
        tau_from=0.9,
        settings=SETTINGS,
    )
    np.testing.assert_allclose(back, late.V_WT, atol=1e-6)
    moved_to(system, simulator, position(curve, 0.2), enable=0.0)
    anew, _ = moved_to(system, simulator, position(curve, 0.2))
    fresh = follow(
        plan(),
        START.rotation(),
        RigidTransform(START.rotation(), position(curve, 0.2)),
        tau_from=0.0,
        settings=SETTINGS,
    )
    np.testing.assert_allclose(anew, fresh.V_WT, atol=1e-9)


def test_new_plan_begins_a_new_motion():
    system = TrajectoryFollower(SETTINGS)
    simulator = Simulator(system)
    end = plan().p_WT
    moved_to(system, simulator, end + np.array([-0.05, 0, 0]))
    assert outputs(system, simulator.get_context())[1] == 1.0
    other = plan((0.5, 0.2, 0.3))
    velocity, missed = moved_to(system, simulator, START.translation(), to=other)
    assert missed == 0.0
    assert velocity[5] > 0.9 * SETTINGS.speed_m_per_s


def test_touch_is_missed_beyond_the_margin_only():
    system = TrajectoryFollower(SETTINGS)
    simulator = Simulator(system)
    end = plan().p_WT
    assert moved_to(system, simulator, end - np.array([0.008, 0, 0]))[1] == 0.0
    assert moved_to(system, simulator, end - np.array([0.012, 0, 0]))[1] == 1.0


def test_two_contexts_of_one_follower_are_independent():
    system = TrajectoryFollower(SETTINGS)
    far, fresh = Simulator(system), Simulator(system, system.CreateDefaultContext())
    moved_to(system, far, plan().p_WT - np.array([0.05, 0, 0]))
    moved_to(system, fresh, START.translation())
    assert outputs(system, far.get_context())[1] == 1.0
    assert outputs(system, fresh.get_context())[1] == 0.0


def test_unconnected_ports_are_named():
    system = TrajectoryFollower(SETTINGS)
    with pytest.raises(RuntimeError, match="enable"):
        outputs(system, system.CreateDefaultContext())


def test_the_orientation_at_the_start_is_remembered_while_the_fingertip_turns():
    system = TrajectoryFollower(SETTINGS)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    fix(system, context, START)
    pose = system.GetInputPort("fingertip_pose").FixValue(context, Value(START))
    simulator.AdvanceTo(0.02)
    turned = RigidTransform(RollPitchYaw(0.5, -0.4, 0.8), position(plan().control_points, 0.5))
    pose.GetMutableData().set_value(turned)  # In place, as the cache of a source does.
    expected = follow(plan(), START.rotation(), turned, tau_from=0.0, settings=SETTINGS)
    np.testing.assert_allclose(outputs(system, context)[0], expected.V_WT, atol=1e-9)
