import dataclasses as dc
import re

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import PortDataType

from vh_drake.objects.loading import load_object
from vh_drake.scenes.placing import draw_object_pose, place_object
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.station import Station, make_station
from vh_drake.sensing.hand_load import GRAVITY_W, HandInertia, HandMotion, own_load
from vh_drake.sensing.wrist_noise import WristNoiseSettings

SCENARIO = Scenario(object="fruit_drink", contact="point")
MODEL = load_object(SCENARIO.object)
ABSTRACT = -1
INPUTS = {"spatial_velocity": 6, "motor_command": 2}
OUTPUTS = {
    "cloud": ABSTRACT,
    "depth_image": ABSTRACT,
    "commanded_state": 16,
    "commanded_pose": ABSTRACT,
    "joint_state": 16,
    "hand_pose": ABSTRACT,
    "hand_velocity": 6,
    "hand_acceleration": 6,
    "wrist_wrench": 6,
    "motor_fraction": 2,
    "tendon_force": 5,
    "finger_joints": 14,
    "query_object": ABSTRACT,
}


class Rig:
    """A station that is told what to do by hand."""

    def __init__(self, scenario=SCENARIO):
        self.station = make_station(scenario, MODEL)
        self.simulator = Simulator(self.station)
        self.context = self.simulator.get_mutable_context()
        place_object(self.station, self.context, draw_object_pose(scenario, MODEL))
        self.command(np.zeros(6), np.zeros(2))

    def command(self, velocity, motors):
        self.station.GetInputPort("spatial_velocity").FixValue(self.context, velocity)
        self.station.GetInputPort("motor_command").FixValue(self.context, motors)

    def advance(self, duration_s):
        self.simulator.AdvanceTo(self.context.get_time() + duration_s)

    def get(self, name):
        return self.station.GetOutputPort(name).Eval(self.context)

    def pose_of(self, body, instance):
        plant = self.station.world.plant
        body = plant.GetBodyByName(body, instance)
        return plant.EvalBodyPoseInWorld(plant.GetMyContextFromRoot(self.context), body)


@pytest.fixture(scope="module")
def rest():
    """After half a second without a command; with the hand's path, every 50 ms."""
    rig = Rig(dc.replace(SCENARIO, wrist=WristNoiseSettings(0.0, 0.0, 0.0, 0.0)))
    path = [rig.pose_of("hand_palm", rig.station.world.hand).translation().copy()]
    for _ in range(10):
        rig.advance(0.05)
        path.append(rig.pose_of("hand_palm", rig.station.world.hand).translation().copy())
    return rig, np.array(path)


def size(port):
    return port.size() if port.get_data_type() == PortDataType.kVectorValued else ABSTRACT


def test_ports_have_the_documented_names_and_sizes(rest):
    station = rest[0].station
    inputs = [station.get_input_port(i) for i in range(station.num_input_ports())]
    outputs = [station.get_output_port(i) for i in range(station.num_output_ports())]
    assert {port.get_name(): size(port) for port in inputs} == INPUTS
    sizes = {port.get_name(): size(port) for port in outputs}
    plant = station.world.plant
    assert sizes.pop("ground_truth") == plant.num_multibody_states()
    assert sizes == OUTPUTS
    documented = re.findall(r"^\s*\| (\w+)\s*\| (in|out)\b", Station.__doc__, re.MULTILINE)
    found = [(p.get_name(), "in") for p in inputs] + [(p.get_name(), "out") for p in outputs]
    assert sorted(documented) == sorted(found)


def test_the_hand_pose_is_the_plant_s(rest):
    rig, _ = rest
    truth = rig.pose_of("hand_palm", rig.station.world.hand)
    np.testing.assert_allclose(rig.get("hand_pose").GetAsMatrix4(), truth.GetAsMatrix4(), atol=1e-6)


def test_the_arm_holds_still_without_a_command(rest):
    _, path = rest
    assert np.linalg.norm(path - path[0], axis=1).max() < 0.0005


def test_at_rest_the_wrist_feels_the_hand_s_weight(rest):
    rig, _ = rest
    plant, hand = rig.station.world.plant, rig.station.world.hand
    context = plant.GetMyContextFromRoot(rig.context)
    mass = plant.CalcTotalMass(context, [hand])
    p_WCom = plant.CalcCenterOfMassPositionInWorld(context, [hand])
    X_WH = rig.get("hand_pose")
    weight = X_WH.rotation().inverse() @ (mass * GRAVITY_W)
    lever = X_WH.inverse() @ p_WCom
    expected = np.concatenate([np.cross(lever, weight), weight])
    wrench = rig.get("wrist_wrench")
    np.testing.assert_allclose(wrench[3:], expected[3:], atol=0.02)
    np.testing.assert_allclose(wrench[:3], expected[:3], atol=0.002)


@pytest.mark.parametrize("step_s", [0.001, 0.0025])
def test_the_wrist_s_load_and_the_hand_s_acceleration_are_of_one_step(step_s):
    quiet = WristNoiseSettings(0.0, 0.0, 0.0, 0.0)
    rig = Rig(dc.replace(SCENARIO, time_step_s=step_s, wrist=quiet))
    hand = rig.station.hand
    inertia = HandInertia(hand.mass_kg, hand.p_HCom, hand.I_H)
    rig.advance(0.2)
    fastest = 0.0
    for i in range(1, 41):
        if i % 10 == 1:
            rig.command(np.array([0.0, 0.0, 0.0, 0.0, 0.2 * (i % 20 == 1), 0.0]), np.zeros(2))
        rig.advance(0.005)
        acceleration = rig.get("hand_acceleration")
        R_WH = rig.get("hand_pose").rotation().matrix()
        w_WH = rig.get("hand_velocity")[:3]
        motion = HandMotion(R_WH, w_WH, acceleration[:3], acceleration[3:])
        outside = rig.get("wrist_wrench") - own_load(inertia, motion)
        fastest = max(fastest, float(np.linalg.norm(acceleration[3:])))
        assert np.linalg.norm(outside[3:]) < 0.1
    assert fastest > 1.0


def test_a_commanded_velocity_moves_the_hand_so():
    rig = Rig()
    rig.advance(0.1)
    start = rig.get("hand_pose").GetAsMatrix4()
    wanted = np.array([0.0, 0.0, 0.1, 0.02, -0.03, 0.04])
    rig.command(wanted, np.zeros(2))
    rig.advance(0.4)
    end = rig.get("hand_pose").GetAsMatrix4()
    np.testing.assert_allclose(end[:3, 3] - start[:3, 3], 0.4 * wanted[3:], atol=0.002)
    np.testing.assert_allclose(rig.get("hand_velocity"), wanted, atol=0.02)
    turn = end[:3, :3] @ start[:3, :3].T
    assert np.arctan2(turn[1, 0], turn[0, 0]) == pytest.approx(0.04, abs=0.004)


def test_motors_close_the_fingers_as_told_and_know_their_joints():
    rig = Rig()
    rig.command(np.zeros(6), np.array([0.5, 0.25]))
    rig.advance(0.7)
    fraction = rig.get("motor_fraction")
    np.testing.assert_allclose(fraction, [0.5, 0.25], atol=0.01)
    plant = rig.station.world.plant
    context = plant.GetMyContextFromRoot(rig.context)
    joints = [
        plant.GetJointByName(name, rig.station.world.hand) for name in rig.station.hand.joints
    ]
    angles = np.array([joint.get_angle(context) for joint in joints])
    estimate = rig.get("finger_joints")
    # Their weight bends single joints; the tendon, a stiff spring, holds their sum.
    np.testing.assert_allclose(estimate, angles, atol=np.deg2rad(10.0))
    for own in (slice(0, 12), slice(12, 14)):
        assert estimate[own].sum() == pytest.approx(angles[own].sum(), rel=0.04)
    assert (rig.get("tendon_force") >= 0.0).all()


def test_a_left_hand_is_the_right_one_s_mirror_image_and_stays_open():
    rig = Rig(dc.replace(SCENARIO, left_hand=True))
    world = rig.station.world
    assert world.left_hand is not None
    rig.advance(0.05)
    plant = world.plant
    context = plant.GetMyContextFromRoot(rig.context)
    mirror = np.diag([1.0, -1.0, 1.0])
    for tip in ("index_distal", "thumb_distal"):
        right = rig.pose_of("hand_palm", world.hand).inverse() @ rig.pose_of(tip, world.hand)
        left = rig.pose_of("hand_palm", world.left_hand).inverse() @ rig.pose_of(
            tip, world.left_hand
        )
        np.testing.assert_allclose(left.translation(), mirror @ right.translation(), atol=2e-3)
    motor = plant.GetJointByName("finger_motor", world.left_hand)
    assert abs(motor.get_translation(context)) < 1e-4
    palm = rig.pose_of("hand_palm", world.left_hand)
    frame = plant.GetFrameByName("hand_fixed_r0").CalcPoseInWorld(context)
    assert palm.IsNearlyEqualTo(frame, 1e-9)
    assert palm.translation()[1] > 0.2
    assert rig.get("motor_fraction").shape == (2,)
    assert rig.get("finger_joints").shape == (14,)


def test_without_the_option_there_is_no_left_hand(rest):
    assert rest[0].station.world.left_hand is None
