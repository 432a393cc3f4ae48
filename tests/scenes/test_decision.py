import re

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator

from vh_drake.exploration.touch_motion import pad_in_hand
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.scenes.decision import (
    INPUTS,
    Decision,
    make_contact_estimator,
    make_decision,
    touching_skin,
)
from vh_drake.scenes.plant import default_hand
from vh_drake.scenes.scenario import Scenario
from vh_drake.sensing.hand_load import HandInertia, HandMotion, own_load

# What a real ARMAR-6 measures or computes from it.
SENSED = {
    "cloud",
    "wrist_wrench",
    "hand_pose",
    "hand_velocity",
    "hand_acceleration",
    "commanded_pose",
    "commanded_state",
    "motor_fraction",
}


@pytest.fixture(scope="module")
def decision():
    return make_decision(Scenario())


def names(ports):
    return [port.get_name() for port in ports]


def inputs_of(system):
    return [system.get_input_port(i) for i in range(system.num_input_ports())]


def outputs_of(system):
    return [system.get_output_port(i) for i in range(system.num_output_ports())]


def test_the_decision_sees_what_a_robot_senses_and_nothing_else(decision):
    assert set(names(inputs_of(decision))) <= SENSED
    assert {name for name, _, _ in INPUTS} == set(names(inputs_of(decision)))


def test_ports_are_those_of_the_documentation(decision):
    documented = re.findall(r"^\s*\| (\w+)\s*\| (in|out)\b", Decision.__doc__, re.MULTILINE)
    found = [(name, "in") for name in names(inputs_of(decision))]
    found += [(name, "out") for name in names(outputs_of(decision))]
    assert sorted(documented) == sorted(found)


@pytest.mark.parametrize(
    ("step_s", "period_s"), [(0.0005, 0.005), (0.002, 0.004), (0.0025, 0.005), (0.01, 0.01)]
)
def test_the_wrist_is_read_where_the_plant_steps(step_s, period_s):
    decision = make_decision(Scenario(time_step_s=step_s))
    estimator = decision.GetSubsystemByName("contact_estimator")
    event = estimator.GetUniquePeriodicDiscreteUpdateAttribute()
    assert event.period_sec() == pytest.approx(period_s, abs=1e-12)


def test_a_described_hand_s_own_weight_is_not_felt_when_it_turns():
    hand = read_hand_model(load_hand(hand_file("armar3_right")))
    estimator = make_contact_estimator(hand, 0.001)
    simulator = Simulator(estimator)
    context = simulator.get_mutable_context()
    for name, size in (("hand_velocity", 6), ("hand_acceleration", 6), ("approach_direction", 3)):
        estimator.GetInputPort(name).FixValue(context, np.zeros(size))
    inertia = HandInertia(hand.mass_kg, hand.p_HCom, hand.I_H)
    for tare, until, pitch in ((0.0, 0.1, 0.0), (1.0, 0.2, 0.0), (1.0, 0.5, 1.2)):
        X_WH = RigidTransform(RollPitchYaw(0.0, pitch, 0.0), np.zeros(3))
        still = HandMotion(X_WH.rotation().matrix(), np.zeros(3), np.zeros(3), np.zeros(3))
        estimator.GetInputPort("hand_pose").FixValue(context, Value(X_WH))
        estimator.GetInputPort("wrist_wrench").FixValue(context, own_load(inertia, still))
        estimator.GetInputPort("tare").FixValue(context, [tare])
        simulator.AdvanceTo(until)
    np.testing.assert_allclose(estimator.GetOutputPort("force").Eval(context), 0.0, atol=1e-9)
    assert estimator.GetOutputPort("contact").Eval(context)[0] == 0.0


def test_the_touching_finger_s_pad_comes_first():
    hand = read_hand_model(load_hand(default_hand()))
    skin = touching_skin(hand)
    p, n = pad_in_hand(hand)
    gaps = np.linalg.norm(skin.p_H - p, axis=1)
    assert gaps[0] < 0.012
    np.testing.assert_allclose(skin.p_HExpected, p)
    assert (skin.n_H @ n > 0.3).all()
