import numpy as np
import pytest
import trimesh

from vh_drake.grasping.motions import hand_axes
from vh_drake.grasping.planner_poses import approach_axes, make_site
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.surface_planner import propose_on_surface

SETTINGS = PlannerSettings(approaches=["collect", "side", "free"], draws=150)


@pytest.fixture(scope="module")
def brick(hand, table, standing):
    mesh = trimesh.creation.box([0.05, 0.08, 0.05]).subdivide()
    return make_site(standing(mesh), table, hand, SETTINGS, 0)


@pytest.fixture(scope="module")
def bottle(hand, table, standing):
    mesh = trimesh.creation.cylinder(0.035, 0.19).subdivide()
    return make_site(standing(mesh), table, hand, SETTINGS, 0)


def proposed(site, approach, seed=0):
    return propose_on_surface(site, approach, np.random.default_rng(seed))


def test_tall_objects_are_taken_from_the_side_and_low_ones_collected(brick, bottle):
    assert len(proposed(brick, "collect")) > 50
    assert len(proposed(brick, "side")) == 0
    assert len(proposed(bottle, "collect")) == 0
    assert len(proposed(bottle, "side")) > 20


def test_candidates_come_from_all_around(brick):
    X_WH = proposed(brick, "collect", 7)
    headings = np.arctan2(X_WH[:, 1, 2], X_WH[:, 0, 2])
    assert (np.histogram(headings, 6, (-np.pi, np.pi))[0] > 0).all()


def test_palms_of_side_grasps_face_the_axis_of_a_bottle(bottle, hand):
    X_WH = proposed(bottle, "side")
    palm = X_WH[:, :3, :3] @ hand_axes(hand)[1]
    to_axis = np.array([0.7, -0.3]) - X_WH[:, :2, 3]
    assert ((palm[:, :2] * to_axis).sum(axis=1) > 0).all()


def test_free_hands_approach_against_the_normal_with_any_roll(bottle, hand):
    X_WH = proposed(bottle, "free")
    approach_H, closing_H = approach_axes(hand)
    approach = X_WH[:, :3, :3] @ approach_H
    assert (bottle.n_TS @ -approach.T).max(axis=0) == pytest.approx(1, abs=1e-9)
    closing = X_WH[:, :3, :3] @ closing_H
    assert np.ptp(np.abs(closing[:, 2])) > 0.5
