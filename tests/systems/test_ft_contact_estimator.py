import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator

from vh_drake.sensing.contact_point import pad_skin
from vh_drake.sensing.hand_load import HandInertia, HandMotion, own_load
from vh_drake.systems.ft_contact_estimator import FtContactEstimator

P_PAD = np.array([0.0202, -0.0107, 0.1278])
SKIN = pad_skin(P_PAD, np.array([-0.962, 0.0, 0.272]))
X_WH = RigidTransform(RollPitchYaw(0.1, 2.0, 0.4), [0.7, -0.3, 1.1])
R_WH = X_WH.rotation().matrix()
REST = own_load(HandInertia(), HandMotion(R_WH, np.zeros(3), np.zeros(3), np.zeros(3)))
FORCE_H = 0.5 * np.array([0.962, 0.0, -0.272])  # onto the pad
PUSH = np.concatenate([np.cross(P_PAD, FORCE_H), FORCE_H])


def fix(system, context, *, push=0.0, tare=0.0):
    system.GetInputPort("wrist_wrench").FixValue(context, REST + push * PUSH)
    system.GetInputPort("hand_pose").FixValue(context, Value(X_WH))
    for name in ("hand_velocity", "hand_acceleration"):
        system.GetInputPort(name).FixValue(context, np.zeros(6))
    system.GetInputPort("tare").FixValue(context, [tare])
    system.GetInputPort("approach_direction").FixValue(context, R_WH @ -FORCE_H)


def started(system, *, caching=True):
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    fix(system, context)
    simulator.AdvanceTo(0.05)
    fix(system, context, tare=1.0)
    simulator.AdvanceTo(0.1)
    return simulator, context


def outputs(system, context):
    return (
        system.GetOutputPort("contact").Eval(context)[0],
        system.GetOutputPort("contact_point").Eval(context),
        system.GetOutputPort("force").Eval(context).copy(),
    )


def touched(*, caching=True):
    system = FtContactEstimator(SKIN)
    simulator, context = started(system, caching=caching)
    before = outputs(system, context)
    fix(system, context, push=1.0, tare=1.0)
    simulator.AdvanceTo(0.3)
    return before, outputs(system, context)


def test_a_push_on_the_pad_is_felt_placed_and_directed():
    before, (contact, points, force) = touched()
    assert before[0] == 0.0
    assert len(before[1]) == 0
    assert contact == 1.0
    np.testing.assert_allclose(points.p_WC[0], X_WH @ P_PAD, atol=1e-3)
    np.testing.assert_allclose(points.n_WC[0], R_WH @ FORCE_H / 0.5, atol=1e-3)
    np.testing.assert_allclose(force, R_WH @ FORCE_H, atol=2e-3)


def test_caching_changes_nothing():
    (_, with_cache), (_, without) = touched(), touched(caching=False)
    assert with_cache[0] == without[0]
    np.testing.assert_array_equal(with_cache[1].p_WC, without[1].p_WC)
    np.testing.assert_array_equal(with_cache[2], without[2])


def test_a_push_that_was_there_at_the_tare_is_no_contact():
    system = FtContactEstimator(SKIN)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    fix(system, context, push=1.0)
    simulator.AdvanceTo(0.2)
    fix(system, context, push=1.0, tare=7.0)
    simulator.AdvanceTo(0.4)
    assert outputs(system, context)[0] == 0.0


def test_two_contexts_of_one_system_are_independent():
    system = FtContactEstimator(SKIN)
    first, first_context = started(system)
    second, second_context = started(system)
    fix(system, first_context, push=1.0, tare=1.0)
    first.AdvanceTo(0.3)
    second.AdvanceTo(0.3)
    assert outputs(system, first_context)[0] == 1.0
    assert outputs(system, second_context)[0] == 0.0


def test_a_reading_that_is_not_finite_is_passed_over():
    system = FtContactEstimator(SKIN)
    simulator, context = started(system)
    system.GetInputPort("wrist_wrench").FixValue(context, np.full(6, np.nan))
    simulator.AdvanceTo(0.2)
    contact, _, force = outputs(system, context)
    assert contact == 0.0
    assert np.isfinite(force).all()


def test_a_felt_contact_does_not_change_with_the_estimator_s_state():
    system = FtContactEstimator(SKIN)
    simulator, context = started(system)
    fix(system, context, push=1.0, tare=1.0)
    simulator.AdvanceTo(0.3)
    points = outputs(system, context)[1]
    felt = points.p_WC.copy()
    fix(system, context, tare=1.0)
    simulator.AdvanceTo(0.5)
    fix(system, context, tare=2.0)  # Forgets the contact.
    simulator.AdvanceTo(0.6)
    assert outputs(system, context)[0] == 0.0
    np.testing.assert_array_equal(points.p_WC, felt)
