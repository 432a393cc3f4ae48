import dataclasses as dc

import numpy as np
import pytest
import trimesh
from scenery import (
    CAN,
    TABLE,
    can_scene,
    can_view,
    right_arm,
    right_hand,
    touch_of_the_can,
)

from vh_drake.control.reach import rollout
from vh_drake.exploration.touch_motion import (
    TouchMotionSettings,
    find_touch,
    finger_end_frame,
    fingertip_frame,
    pad_in_hand,
    pads_in_hand,
    shifted,
    touching_poses,
)
from vh_drake.geometry.signed_distance import interpolate
from vh_drake.hand.clearance import link_clearance, obstacles
from vh_drake.types import Surface, TouchPlan

SETTINGS = TouchMotionSettings()
VIEW = can_view()
CAMERA = VIEW.p_WCamera
BACK = touch_of_the_can(0.0)


@pytest.fixture(scope="module")
def motion():
    arm = right_arm()
    return find_touch([BACK], can_scene(), right_hand(), arm, arm.home, VIEW)


def plan_towards(n):
    n = np.asarray(n, float) / np.linalg.norm(n)
    return dc.replace(BACK, n_WT=n)


@pytest.mark.parametrize("n", [(1, 0, 0), (0.3, -0.8, 0.2), (-0.5, 0.1, -0.4), (0, 0, 1)])
def test_every_roll_puts_the_pad_flat_on_the_target(n):
    hand, plan = right_hand(), plan_towards(n)
    p, normal = pad_in_hand(hand)
    poses = list(touching_poses(plan, fingertip_frame(hand), TABLE.normal, SETTINGS))
    assert len(poses) == len(SETTINGS.rolls_deg)
    for X_WH in poses:
        R = X_WH[:3, :3]
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(R) == pytest.approx(1.0)
        np.testing.assert_allclose(R @ p + X_WH[:3, 3], plan.p_WT, atol=1e-9)
        np.testing.assert_allclose(R @ normal, -plan.n_WT, atol=1e-9)


def test_rolls_turn_the_hand_about_the_normal_by_their_angles():
    hand = right_hand()
    poses = list(touching_poses(BACK, fingertip_frame(hand), TABLE.normal, SETTINGS))
    for roll, X_WH in zip(SETTINGS.rolls_deg, poses, strict=True):
        turn = X_WH[:3, :3] @ poses[0][:3, :3].T
        assert np.rad2deg(np.arccos((np.trace(turn) - 1) / 2)) == pytest.approx(abs(roll))
        np.testing.assert_allclose(turn @ BACK.n_WT, BACK.n_WT, atol=1e-12)


def test_the_fingertip_frame_points_out_of_the_pad_that_reaches_farthest():
    hand = right_hand()
    X_HT, (pads, normals) = fingertip_frame(hand), pads_in_hand(hand)
    along = pads @ np.asarray(hand.description.along)
    np.testing.assert_allclose(X_HT[:3, 3], pads[np.argmax(along)])
    np.testing.assert_allclose(X_HT[:3, 2], normals[np.argmax(along)])
    np.testing.assert_allclose(X_HT[:3, :3].T @ X_HT[:3, :3], np.eye(3), atol=1e-12)
    assert len(pads) == 4  # The thumb is left out.


def test_the_touch_starts_off_the_target_and_ends_on_it(motion):
    curve, n = motion.plan.control_points, motion.plan.n_WT
    np.testing.assert_allclose(curve[0], BACK.p_WT + SETTINGS.standoff_m * BACK.n_WT, atol=1e-9)
    np.testing.assert_allclose(curve[3], BACK.p_WT, atol=1e-9)
    assert n @ BACK.n_WT > 0.9
    settle, feel = motion.legs[-2:]
    assert feel.guarded
    np.testing.assert_allclose(feel.touch.p_WT, BACK.p_WT, atol=1e-9)
    np.testing.assert_allclose(feel.touch.n_WT, BACK.n_WT, atol=1e-9)
    np.testing.assert_allclose(
        feel.X_WH, shifted(settle.X_WH, -SETTINGS.standoff_m * BACK.n_WT), atol=1e-12
    )


def test_only_the_touch_itself_brings_the_hand_near_the_object(motion):
    hand, scene = right_hand(), can_scene()
    for leg in motion.legs[:-1]:
        links, table = link_clearance(hand, leg.X_WH, scene)
        assert links.min() >= SETTINGS.travel_clearance_m
        assert table >= SETTINGS.table_clearance_m


def test_the_arm_follows_the_legs_and_the_retreat(motion):
    arm = right_arm()
    way = [leg.X_WH for leg in (*motion.legs[:-1], *motion.retreat)]
    assert rollout(arm, arm.home, way).reached


def test_the_hand_travels_over_the_object_and_not_through_it(motion):
    raised, over, before = motion.legs[:3]
    assert raised.X_WH[2, 3] == pytest.approx(over.X_WH[2, 3])
    np.testing.assert_allclose(over.X_WH[:2, 3], before.X_WH[:2, 3], atol=1e-12)
    lowest = link_clearance(right_hand(), over.X_WH, can_scene())[1]
    assert lowest >= can_scene().top_m + SETTINGS.safe_height_m - 1e-9


def rotated(plan, heading):
    """The same touch on the can, at another heading about its axis."""
    c, s = np.cos(heading), np.sin(heading)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return dc.replace(plan, p_WT=CAN + R @ (plan.p_WT - CAN), n_WT=R @ plan.n_WT)


def test_low_and_undercut_places_are_approached_level():
    low = touch_of_the_can(0.0, height_m=0.905)
    under = dc.replace(low, n_WT=np.array([0.8, 0.0, -0.6]))
    arm = right_arm()
    for plan in (low, under):
        turned = [rotated(plan, heading) for heading in np.linspace(-1.5, 1.5, 7)]
        found = find_touch(turned, can_scene(), right_hand(), arm, arm.home, VIEW)
        curve = found.plan.control_points
        assert curve[3, 2] == pytest.approx(curve[0, 2], abs=1e-9)
        assert SETTINGS.least_height_m - 1e-3 < TABLE.height(found.plan.p_WT) < SETTINGS.low_m


def test_the_first_feasible_plan_is_taken():
    far = dc.replace(BACK, p_WT=BACK.p_WT + np.array([2.0, 0.0, 0.0]))
    arm = right_arm()
    found = find_touch([far, BACK], can_scene(), right_hand(), arm, arm.home, VIEW)
    np.testing.assert_allclose(found.legs[-1].touch.p_WT, BACK.p_WT)
    assert find_touch([far], can_scene(), right_hand(), arm, arm.home, VIEW) is None
    assert find_touch([], can_scene(), right_hand(), arm, arm.home, VIEW) is None


def test_a_touch_inside_the_object_is_refused():
    inside = dc.replace(BACK, p_WT=CAN.copy())
    arm = right_arm()
    assert find_touch([inside], can_scene(), right_hand(), arm, arm.home, VIEW) is None


def test_the_predicted_touch_lies_on_the_estimate_and_faces_away_from_the_camera(motion):
    p, n = motion.plan.p_WT, motion.plan.n_WT
    assert abs(interpolate(can_scene().distance, p[None])[0][0]) < 2e-3
    assert n @ (CAMERA - p) < 0
    assert np.linalg.norm(n) == pytest.approx(1.0)


def test_the_end_of_the_finger_leads_where_the_finger_leans():
    pad, end = fingertip_frame(right_hand()), finger_end_frame(right_hand(), np.deg2rad(22.0))
    assert (end[:3, 3] - pad[:3, 3]) @ end[:3, 2] > 0
    np.testing.assert_allclose(end[:3, :3].T @ end[:3, :3], np.eye(3), atol=1e-12)


def test_the_far_side_of_a_low_thing_is_touched_by_an_upright_finger():
    bar = trimesh.creation.box((0.04, 0.12, 0.036)).subdivide_to_size(0.01)
    bar.apply_translation((0.72, -0.25, 0.918))
    surface = Surface(
        np.array(bar.vertices), np.array(bar.faces, np.int64), np.array(bar.vertex_normals)
    )
    n, p = np.array([1.0, 0.0, 0.0]), np.array([0.74, -0.25, 0.917])
    plan = TouchPlan(p, n, np.linspace(p + 0.1 * n, p, 4))
    hand, arm, scene = right_hand(), right_arm(), obstacles(surface, TABLE)
    found = find_touch([plan], scene, hand, arm, arm.home, VIEW)
    assert found is not None
    to_camera = (CAMERA - found.plan.p_WT) / np.linalg.norm(CAMERA - found.plan.p_WT)
    assert found.plan.n_WT @ to_camera < -0.3
    low_only = dc.replace(SETTINGS, low_tilts_deg=SETTINGS.low_tilts_deg[:1])
    assert find_touch([plan], scene, hand, arm, arm.home, VIEW, low_only) is None


@pytest.mark.parametrize(("covariance", "heading"), [((0.0, 0.0), 0.0), ((0.0, 0.02), 1.2)])
def test_where_the_camera_may_be_aside_it_is_touched_from_the_side(covariance, heading):
    view = dc.replace(VIEW, shift_covariance=np.diag([*np.square(covariance), 0.0]))
    plans = [touch_of_the_can(angle) for angle in (0.0, 1.2)]
    arm = right_arm()
    found = find_touch(plans, can_scene(), right_hand(), arm, arm.home, view)
    assert np.arctan2(found.plan.n_WT[1], found.plan.n_WT[0]) == pytest.approx(heading, abs=0.25)


def test_the_way_of_a_touch_ends_where_the_hand_is(motion):
    way = motion.way(motion.legs[-1].X_WH)
    np.testing.assert_allclose(way[0], motion.legs[-2].X_WH, atol=1e-12)
    np.testing.assert_allclose(way[-1], motion.legs[-1].X_WH, atol=1e-12)
