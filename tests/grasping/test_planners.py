import dataclasses as dc
from collections import Counter

import numpy as np
import pytest
import trimesh
from scenery import right_arm
from scipy.spatial.transform import Rotation

from vh_drake.control.reach import rollout
from vh_drake.errors import BadInput, UnknownName
from vh_drake.grasping.approach import GraspMotionSettings, approach_poses
from vh_drake.grasping.closing import close_hand
from vh_drake.grasping.field import object_field
from vh_drake.grasping.motions import hand_axes, motion_of
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.clearance import link_clearance, obstacles
from vh_drake.types import Candidates, Plane, Surface

SETTINGS = PlannerSettings(candidates=60, draws=100)


def brick():
    return trimesh.creation.box([0.05, 0.08, 0.05]).subdivide()


def bottle():
    return trimesh.creation.cylinder(0.035, 0.19).subdivide()


def test_both_planners_give_half_of_the_candidates_by_default(hand, table, standing):
    candidates = plan_candidates(standing(brick()), table, hand, SETTINGS)
    assert Counter(candidates.planner) == {"surface": 30, "skeleton": 30}
    assert len(candidates.X_WH) == len(candidates.motion) == 60


@pytest.mark.parametrize("planner", ["surface", "skeleton"])
def test_one_planner_alone_gives_all(hand, table, standing, planner):
    settings = dc.replace(SETTINGS, planners=[planner])
    assert plan_candidates(standing(brick()), table, hand, settings).planner == (planner,) * 60


@pytest.mark.parametrize("mesh", [brick(), bottle()])
def test_every_candidate_starts_free_of_object_and_table_and_most_touch(
    hand, table, standing, mesh
):
    surface = standing(mesh.copy())
    settings = dc.replace(SETTINGS, approaches=["collect", "side", "free"])
    field, scene = object_field(surface, table), obstacles(surface, table)
    candidates = plan_candidates(surface, table, hand, settings, 1)
    closures = [
        close_hand(hand, field, motion_of(motion, hand, settings.collect), X)
        for X, motion in zip(candidates.X_WH, candidates.motion, strict=True)
    ]
    assert all(closure.started_free for closure in closures)
    assert all(link_clearance(hand, X, scene)[1] > -0.001 for X in candidates.X_WH)
    assert np.mean([len(closure.links) >= 3 for closure in closures]) > 0.8


def test_collecting_hands_start_just_over_the_table_or_up_to_30_mm_higher(hand, table, standing):
    candidates = plan_candidates(standing(brick()), table, hand, SETTINGS, 2)
    centers, radii = hand.spheres(hand.lower)
    for X in candidates.X_WH:
        lowest = (centers @ X[2, :3] + X[2, 3] - radii).min() - 0.9
        assert 0.004 - 1e-9 <= lowest <= 0.034 + 1e-9


def test_side_grasps_have_the_thumb_up_and_fingers_that_point_down_at_most_25_degrees(
    hand, table, standing
):
    candidates = plan_candidates(standing(bottle()), table, hand, SETTINGS, 3)
    assert set(candidates.motion) == {"side"}
    along, palm = hand_axes(hand)
    R = candidates.X_WH[:, :3, :3]
    tilts = np.degrees(np.arcsin(-(R @ along)[:, 2]))
    assert -1e-6 <= tilts.min() < 5.0 < 15.0 < tilts.max() <= 25.0 + 1e-6
    np.testing.assert_allclose((R @ palm)[:, 2], 0, atol=1e-9)
    thumb = (R @ np.cross(along, palm))[:, 2]
    np.testing.assert_allclose(np.abs(thumb), np.cos(np.deg2rad(tilts)), atol=1e-9)
    assert (candidates.X_WH[:, 2, 3] >= 0.9 + 0.065 - 1e-9).all()


def test_with_tilted_fingers_the_arm_takes_an_object_from_more_sides(hand, table, standing):
    sides = {}
    for tilt in (0.0, 25.0):
        settings = PlannerSettings(candidates=800, approaches=["side"], side_tilts_deg=[0.0, tilt])
        X_WH = plan_candidates(standing(bottle()), table, hand, settings, arm=right_arm()).X_WH
        facing = X_WH[:, :3, :3] @ hand_axes(hand)[1]
        angles = np.degrees(np.arctan2(facing[:, 1], facing[:, 0]))
        sides[tilt] = len(np.unique(angles // 20.0))
    assert sides[25.0] >= 1.3 * sides[0.0]


def test_poses_are_rigid(hand, table, standing):
    settings = dc.replace(SETTINGS, approaches=["collect", "side", "free"])
    for mesh in (brick(), bottle()):
        R = plan_candidates(standing(mesh), table, hand, settings, 4).X_WH[:, :3, :3]
        np.testing.assert_allclose(R @ R.swapaxes(1, 2), np.tile(np.eye(3), (60, 1, 1)), atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(R), 1)


def test_the_same_seed_gives_the_same_candidates(hand, table, standing):
    one, other, third = (
        plan_candidates(standing(brick()), table, hand, SETTINGS, seed) for seed in (5, 5, 6)
    )
    np.testing.assert_array_equal(one.X_WH, other.X_WH)
    assert not np.array_equal(one.X_WH, third.X_WH)


def test_a_tilted_table_turns_the_candidates_with_it(hand, table, standing):
    surface = standing(brick())
    R = Rotation.from_rotvec([0.2, -0.1, 0.0]).as_matrix()
    tilted = Surface(surface.vertices @ R.T, surface.faces, surface.normals @ R.T, surface.variance)
    plane = Plane(R @ table.normal, table.offset)
    candidates = plan_candidates(tilted, plane, hand, SETTINGS)
    assert len(candidates) == 60
    heights = [link_clearance(hand, X, obstacles(tilted, plane))[1] for X in candidates.X_WH]
    assert min(heights) > 0.003
    assert max(heights) < 0.036


def test_what_is_too_wide_for_the_hand_gets_no_candidates(hand, table, standing):
    crate = standing(trimesh.creation.box([0.3, 0.3, 0.15]))
    none: Candidates = plan_candidates(crate, table, hand, SETTINGS)
    assert len(none) == 0


@pytest.mark.parametrize(("mesh", "share"), [(brick(), 0.9), (bottle(), 0.7)])
def test_with_an_arm_its_controllers_bring_the_hand_to_most_candidates(
    hand, table, standing, mesh, share
):
    surface, arm, motion = standing(mesh.copy()), right_arm(), GraspMotionSettings()
    candidates = plan_candidates(surface, table, hand, SETTINGS, arm=arm)
    scene, X_WH_now = obstacles(surface, table), arm.pose(arm.home)
    reached = []
    for X, name in zip(candidates.X_WH[::3], candidates.motion[::3], strict=True):
        way = approach_poses(X, name, scene, hand, X_WH_now, motion)
        reached.append(rollout(arm, arm.home, way).reached)
    assert len(reached) == 20
    assert np.mean(reached) >= share


def test_no_candidate_is_left_where_the_arm_does_not_reach(hand, table, standing):
    far = standing(brick(), x=2.0)
    assert len(plan_candidates(far, table, hand, SETTINGS)) == 60
    assert len(plan_candidates(far, table, hand, SETTINGS, arm=right_arm())) == 0


def test_an_empty_surface_gets_no_plan(hand, table):
    with pytest.raises(BadInput, match="empty"):
        plan_candidates(Surface(), table, hand, SETTINGS)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"candidates": 0}, BadInput, "must be positive"),
        ({"planners": []}, BadInput, "name no grasp planner"),
        ({"planners": ["oracle"]}, UnknownName, "unknown grasp planner 'oracle'"),
        ({"approaches": ["below"]}, UnknownName, "unknown approach 'below'"),
    ],
)
def test_settings_that_ask_for_nothing_are_refused(hand, table, standing, changes, error, message):
    with pytest.raises(error, match=message):
        plan_candidates(standing(brick()), table, hand, dc.replace(SETTINGS, **changes))
