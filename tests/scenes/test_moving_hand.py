"""The simulated transmission beside the model of section 4.5.4."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from scenery import right_hand

from vh_drake.errors import BadInput
from vh_drake.grasping.base_joints import base_position
from vh_drake.hand.tendon_finger import TendonFinger, thesis_finger
from vh_drake.objects.loading import load_object
from vh_drake.scenes.moving_hand import make_moving_hand

TENDON_N_M = 5e4  # stiffness of the model's tendons
FINGERS = ("index", "middle", "ring", "little")
FINGER = thesis_finger("constant")
SETTLE_S = 0.6


class Rig:
    """A hand in free space under commands that hold."""

    def __init__(self, command=(0.0, 0.0), by="position", **options):
        self.scene = make_moving_hand(right_hand(), command=by, **options)
        self.plant = self.scene.plant
        self.simulator = Simulator(self.scene.diagram)
        self.root = self.simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)
        self.scene.diagram.GetInputPort("base_state").FixValue(self.root, np.zeros(12))
        self.command(command)

    def command(self, command):
        self.scene.diagram.GetInputPort("motor_command").FixValue(self.root, np.array(command))

    def settle(self, duration_s=SETTLE_S):
        self.simulator.AdvanceTo(self.root.get_time() + duration_s)
        return self

    def angles(self, finger):
        names = [f"{finger}_{joint}" for joint in ("mcp", "pip", "dip")]
        return np.array([self.plant.GetJointByName(n).get_angle(self.context) for n in names])

    def travel(self):
        return self.plant.GetJointByName("finger_motor").get_translation(self.context)

    def pull(self):
        port = self.plant.get_net_actuation_output_port(self.scene.instance)
        return port.Eval(self.context)[0]

    def output(self, name):
        return self.scene.diagram.GetOutputPort(name).Eval(self.root)


def tension_of(finger, angles):
    """That the springs of its free joints show [N]."""
    free = (angles > 0.02) & (angles < finger.upper - 0.02)
    return finger.holding_force(angles)[free]


def test_the_simulated_transmission_is_the_model_s_at_50_shortenings():
    rig = Rig(gravity=False)
    commands = np.linspace(0.02, 1.0, 50)
    errors = []
    for command in commands:
        rig.command([command, 0.0])
        rig.settle(0.2)
        shortening = rig.travel() - rig.pull() / TENDON_N_M  # The tendon gives a little.
        expected = FINGER.equilibrium(min(shortening, FINGER.closed_m)).angles
        errors += [np.abs(rig.angles(finger) - expected).max() for finger in FINGERS]
    assert np.rad2deg(np.max(errors)) < 1.0
    assert rig.angles("middle").min() > np.deg2rad(80)


def test_a_blocked_proximal_joint_lets_medial_and_distal_close_on():
    blocked = Rig(command=(0.5, 0.0), gravity=False, stops={"index_mcp": 0.3}).settle()
    free = Rig(command=(0.5, 0.0), gravity=False).settle()
    assert blocked.angles("index")[0] == pytest.approx(0.3, abs=5e-3)
    assert (blocked.angles("index")[1:] > free.angles("index")[1:] + np.deg2rad(1)).all()


def test_the_pulley_shares_the_pull_equally_whatever_blocks_a_finger():
    rig = Rig(command=(0.5, 0.0), gravity=False, stops={"index_mcp": 0.3, "ring_pip": 0.1})
    rig.settle()
    tensions = [tension_of(FINGER, rig.angles(finger)) for finger in FINGERS[::2]]
    every = np.concatenate(tensions)
    every = every[np.abs(every - np.median(every)) < 1.0]  # Blocked joints show no tension.
    assert len(every) == 4
    assert np.ptp(every) < 0.05 * every.mean()
    np.testing.assert_allclose(rig.output("tendon_force")[:4], every.mean(), rtol=0.05)


def test_fingers_that_are_blocked_leave_the_motor_s_travel_to_the_others():
    stops = {"index_mcp": 0.3, "index_pip": 0.3, "index_dip": 0.3}
    rig = Rig(command=(0.5, 0.0), gravity=False, stops=stops).settle()
    three = TendonFinger(
        *(np.tile(getattr(FINGER, n), 3) for n in ("stiffness", "preload", "lever_open_m")),
        length_m=np.tile(FINGER.length_m, 3) / 4,
        upper=np.tile(FINGER.upper, 3),
        lever="constant",
    )
    blocked_m = 0.9 * FINGER.shortening_per_rad[0] / 4
    shortening = rig.travel() - rig.pull() / TENDON_N_M - blocked_m
    expected = three.equilibrium(shortening).angles.reshape(3, 3)
    for finger, angles in zip(FINGERS[1:], expected, strict=True):
        np.testing.assert_allclose(rig.angles(finger), angles, atol=np.deg2rad(0.5))


def test_a_slack_tendon_costs_nothing():
    rig = Rig(command=(0.0, 0.0), gravity=False).settle()
    assert rig.pull() == pytest.approx(0.0, abs=5e-3)
    closed_by_hand = np.zeros(rig.plant.num_velocities())
    for name in ("index_mcp", "index_pip", "index_dip"):
        closed_by_hand[rig.plant.GetJointByName(name).velocity_start()] = 0.06  # N m
    port = rig.plant.get_applied_generalized_force_input_port()
    port.FixValue(rig.context, closed_by_hand)
    rig.settle()
    springs = FINGER.stiffness * (rig.angles("index") + FINGER.preload)
    np.testing.assert_allclose(springs, 0.06, rtol=5e-3)  # The tendon takes no part.
    assert rig.pull() == pytest.approx(0.0, abs=5e-3)


def test_force_commands_are_pulled_by_the_motors():
    rig = Rig(command=(22.0, 12.0), gravity=False, by="force").settle(2.5)
    assert rig.pull() == pytest.approx(22.0, rel=0.02)
    expected = FINGER.equilibrium(rig.travel() - rig.pull() / TENDON_N_M)
    assert 4 * expected.tension_n == pytest.approx(22.0, rel=0.03)
    rig.command([60.0, 12.0])
    rig.settle(2.0)  # All joints come to their stops, and the pull still follows.
    assert rig.pull() == pytest.approx(60.0, rel=0.02)
    rig.command([0.0, 0.0])
    rig.settle(1.5)
    assert rig.angles("middle").max() < np.deg2rad(3)


def test_joints_are_told_from_the_motors_within_ten_degrees_under_the_hand_s_weight():
    rig = Rig()
    for command in (0.2, 0.5, 0.8):
        rig.command([command, command])
        rig.settle()
        told = rig.output("finger_joints")[:12].reshape(4, 3)
        true = np.array([rig.angles(finger) for finger in FINGERS])
        assert np.rad2deg(np.abs(told - true).max()) < 10.0


def test_the_base_goes_where_it_is_told():
    rig = Rig()
    X_WH = RigidTransform(RollPitchYaw(0.4, 0.5, 2.0), [0.1, -0.1, 0.2]).GetAsMatrix4()
    told = np.r_[base_position(right_hand(), X_WH), np.zeros(6)]
    rig.scene.diagram.GetInputPort("base_state").FixValue(rig.root, told)
    rig.settle(1.0)
    there = rig.plant.GetBodyByName("hand_palm").EvalPoseInWorld(rig.context).GetAsMatrix4()
    np.testing.assert_allclose(there[:3, 3], X_WH[:3, 3], atol=3e-4)
    np.testing.assert_allclose(there[:3, :3], X_WH[:3, :3], atol=5e-3)


def test_an_object_needs_contact():
    with pytest.raises(BadInput, match="point or hydroelastic"):
        make_moving_hand(right_hand(), model=load_object("can"))
