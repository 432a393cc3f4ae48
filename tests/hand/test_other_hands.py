"""Hands that vh_drake was not written for: ARMAR-III's, and one that no part of it knows of."""

import functools
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from scenery import can_surface, can_view, right_arm

from vh_drake.control.reach import rollout
from vh_drake.grasping.closing import close_hand
from vh_drake.grasping.field import ObjectField
from vh_drake.grasping.motions import CollectSettings, collect_pose, motion_of
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.grasping.scoring import ScoringSettings, rate_candidates
from vh_drake.hand.description import load_hand
from vh_drake.hand.mirror import mirrored_sdf
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.objects.loading import load_object
from vh_drake.scenes.hand_lift import HandLifter
from vh_drake.scenes.moving_hand import make_moving_hand
from vh_drake.scenes.scenario import Table
from vh_drake.types import Plane, ScalarGrid, Surface

THREE_FINGERS = Path(__file__).parents[1] / "hands" / "three_fingers.yaml"
HANDS = {"armar3_right": hand_file("armar3_right"), "three_fingers": THREE_FINGERS}
SIZES = {"armar3_right": (5, 10, 5), "three_fingers": (3, 6, 2)}  # fingers, joints, motors
RADIUS_M = 0.03


@functools.cache
def described(name):
    return read_hand_model(load_hand(HANDS[name]))


@pytest.fixture(params=HANDS)
def hand(request):
    return described(request.param)


def ball(center, radius=RADIUS_M, spacing=0.003):
    """The exact distance to a ball far above its table, sampled."""
    count = int(2 * (radius + 0.02) / spacing) + 1
    origin = center - spacing * (count - 1) / 2
    nodes = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1)
    values = np.linalg.norm(origin + spacing * nodes - center, axis=-1) - radius
    below = Plane(np.array([0.0, 0, 1]), -10.0)
    return ObjectField(ScalarGrid(origin, spacing, values), below, center, radius)


def in_hand(hand):
    """A place before the palm that the closing fingers and the thumb come to, in H."""
    half = hand.tips(hand.joint_angles(hand.motor_fractions(0.5, 0.5)))
    opposing = hand.opposing == 1
    return (half[~opposing].mean(axis=0) + half[opposing].mean(axis=0)) / 2


def test_fingers_joints_and_motors_are_read(hand):
    fingers, joints, motors = SIZES[hand.description.name]
    assert (hand.num_fingers, len(hand.joints), len(hand.description.motors)) == (
        fingers,
        joints,
        motors,
    )
    np.testing.assert_array_equal(hand.opposing, [0] * (fingers - 1) + [1])
    np.testing.assert_allclose(hand.joint_angles(np.ones(motors)), hand.upper)
    assert 0.2 < hand.mass_kg < 2.0


def test_armar_iii_has_the_published_lengths():
    # Tips in the hand's base at q = 0, table 3.2 of the facts; H lies at (-23, 0, 119) mm there.
    hand = described("armar3_right")
    tips = hand.tips(hand.lower)
    radii = hand.arrays.sphere_radius[hand.tip_spheres]
    ends = 1e3 * (tips[:4, 2] + radii[:4]) + 119.0
    np.testing.assert_allclose(ends, [204.5, 204.6, 197.0, 189.6], atol=0.3)
    assert 1e3 * (tips[4, 0] - radii[4]) - 23.0 == pytest.approx(-147.9, abs=0.3)


def test_fingers_and_thumb_close_onto_a_ball_without_entering_it(hand):
    center = in_hand(hand)
    motion = motion_of("side", hand, CollectSettings())
    closure = close_hand(hand, ball(center), motion, np.eye(4))
    assert closure.started_free
    fingers = {int(hand.finger_of_link[link]) for link in closure.links}
    assert any(hand.opposing[f] for f in fingers - {-1})
    assert any(not hand.opposing[f] for f in fingers - {-1})
    centers, radii = hand.spheres(closure.angles)
    assert (np.linalg.norm(centers - center, axis=1) - RADIUS_M - radii).min() > -0.002


def test_the_collecting_hand_stays_over_the_table(hand):
    for share in np.linspace(0.0, 1.0, 5):
        angles = hand.joint_angles(hand.motor_fractions(share, share))
        X_TH = collect_pose(hand, angles, CollectSettings())
        centers, radii = hand.spheres(angles)
        lowest = (centers @ X_TH[2, :3] + X_TH[2, 3] - radii).min()
        assert lowest == pytest.approx(CollectSettings().clearance_m, abs=1e-9)


def test_both_planners_find_grasps_within_reach_and_some_hold(hand):
    settings = PlannerSettings(candidates=20, draws=80)
    found = plan_candidates(can_surface(), can_view().table, hand, settings, 0, arm=right_arm())
    assert set(found.planner) == {"surface", "skeleton"}
    arm = right_arm()
    assert all(rollout(arm, arm.home, [X]).reached for X in found.X_WH[::4])
    rated = rate_candidates(found, can_surface(), can_view().table, hand, ScoringSettings(), 0)
    assert rated.rate.max() > 0.5
    assert rated.held.max() > 0.9


def test_the_tendons_close_the_simulated_fingers_as_the_model_says(hand):
    scene = make_moving_hand(hand, gravity=False)
    simulator = Simulator(scene.diagram)
    root = simulator.get_mutable_context()
    scene.diagram.GetInputPort("base_state").FixValue(root, np.zeros(12))
    command = hand.motor_fractions(0.5, 0.5)
    scene.diagram.GetInputPort("motor_command").FixValue(root, command)
    simulator.AdvanceTo(1.2)
    own = scene.plant.GetMyContextFromRoot(root)
    angles = [scene.plant.GetJointByName(name).get_angle(own) for name in hand.joints]
    travel = scene.diagram.GetOutputPort("motor_fraction").Eval(root)
    np.testing.assert_allclose(angles, hand.joint_angles(travel), atol=np.deg2rad(2.0))
    assert min(angles) > np.deg2rad(20.0)


def test_armar_iii_s_hand_has_a_mirror_image():
    text = Path(described("armar3_right").description.model).read_text()
    assert mirrored_sdf(text).count("<link") == text.count("<link")


@pytest.mark.slow
def test_three_fingers_lift_a_can_in_simulation():
    hand, model, table = described("three_fingers"), load_object("can"), Table()
    X_WO = np.eye(4)
    X_WO[:3, 3] = [0.7, -0.3, table.height_m - model.mesh.vertices[:, 2].min()]
    best = best_grasps(hand, model, X_WO, table)
    lifter = HandLifter(hand, model, table)
    lifts = [lifter.lift(X_WO, X_WH, motion) for X_WH, motion in best]
    assert any(lift.lifted and lift.height_m > 0.08 for lift in lifts)


def best_grasps(hand, model, X_WO, table, count=3):
    """The best rated grasps on the true object."""
    mesh = model.mesh
    vertices = mesh.vertices @ X_WO[:3, :3].T + X_WO[:3, 3]
    surface = Surface(vertices, mesh.faces, variance=np.zeros(len(vertices)))
    plane = Plane(np.array([0.0, 0.0, 1.0]), table.height_m)
    settings = PlannerSettings(candidates=40, draws=100)
    found = plan_candidates(surface, plane, hand, settings, 0)
    rated = rate_candidates(found, surface, plane, hand, ScoringSettings(), 0)
    order = np.argsort(-rated.rate * rated.held * rated.centered * rated.placed)[:count]
    return [(found.X_WH[i], found.motion[i]) for i in order]
