import numpy as np
import pytest

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.systems.gravity_compensation import GravityCompensation


def evaluate(system, q, *, caching: bool = True) -> np.ndarray:
    context = system.CreateDefaultContext()
    if not caching:
        context.DisableCaching()
    system.GetInputPort("joint_state").FixValue(context, np.concatenate([q, np.ones(8)]))
    return system.GetOutputPort("torque").Eval(context)


@pytest.mark.parametrize("caching", [True, False])
def test_torque_does_the_work_that_lifts_the_payload(caching):
    bare, loaded = ArmKinematics(), ArmKinematics(payload_kg=1.0, p_HPayload=(0.0, 0.0, 0.0))
    q = bare.home
    difference = evaluate(GravityCompensation(loaded), q, caching=caching) - evaluate(
        GravityCompensation(bare), q, caching=caching
    )
    np.testing.assert_allclose(difference, 9.81 * bare.jacobian(q)[5], atol=1e-9)


def test_two_contexts_do_not_touch_each_other():
    arm = ArmKinematics()
    system = GravityCompensation(arm)
    first = evaluate(system, arm.home)
    other = evaluate(system, (arm.lower + arm.upper) / 2)
    assert np.linalg.norm(first - other) > 0.1
    np.testing.assert_array_equal(evaluate(system, arm.home), first)
