import numpy as np
import pytest
import trimesh

from vh_drake.geometry.skeleton import RAYS, curve_skeleton
from vh_drake.grasping.motions import hand_axes
from vh_drake.grasping.planner_poses import approach_axes, make_site
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.skeleton_planner import placements, propose_along_skeleton
from vh_drake.types import Plane

SETTINGS = PlannerSettings(approaches=["collect", "side", "free"], draws=150)


def lying_bar():
    """Along y, wider than high."""
    return trimesh.creation.box([0.04, 0.18, 0.03]).subdivide().subdivide()


def standing_box():
    """Twice as wide along x as along y."""
    return trimesh.creation.box([0.09, 0.045, 0.18]).subdivide().subdivide()


@pytest.fixture(scope="module")
def bar(hand, table, standing):
    return make_site(standing(lying_bar()), table, hand, SETTINGS, 0)


@pytest.fixture(scope="module")
def column(hand, table, standing):
    return make_site(standing(standing_box()), table, hand, SETTINGS, 0)


def nodes_of(site):
    return placements(curve_skeleton(site.field.distance), site.X_WT, site.settings)


@pytest.fixture(scope="module")
def floating_bar(hand, standing):
    return make_site(standing(lying_bar()), Plane(), hand, SETTINGS, 0)


def proposed(site, approach, seed=0):
    return propose_along_skeleton(site, nodes_of(site), approach, np.random.default_rng(seed))


def test_placements_lie_on_the_section_in_table_axes_and_end_at_the_surface(bar):
    nodes = nodes_of(bar)
    np.testing.assert_allclose(nodes.p[:, 0], 0.7, atol=0.003)
    np.testing.assert_allclose(nodes.p[:, 2], 0.015, atol=0.003)
    np.testing.assert_allclose(np.abs(nodes.direction[:, 1]), 1, atol=0.01)
    assert nodes.rays.shape == (len(nodes), RAYS, 3)
    ends = nodes.outward.any(axis=1)
    assert ends.sum() == 2
    np.testing.assert_allclose(np.sort(nodes.p[ends, 1]), [-0.39, -0.21], atol=0.004)


def test_fingers_close_across_a_lying_bar_or_along_it_at_its_ends(bar, hand):
    X_WH = proposed(bar, "collect")
    fingers = X_WH[:, :3, :3] @ hand_axes(hand)[0]
    fingers = fingers[:, :2] / np.linalg.norm(fingers[:, :2], axis=1, keepdims=True)
    across = np.abs(fingers[:, 0]) > np.cos(np.deg2rad(40))
    assert len(X_WH) > 40
    assert across.mean() > 0.8  # Along it the bar is too long, but for its ends.


def test_fingers_of_side_grasps_prefer_the_narrow_side_of_a_column(column, hand):
    X_WH = proposed(column, "side")
    fingers = X_WH[:, :3, :3] @ hand_axes(hand)[0]
    assert len(X_WH) > 20
    assert (np.abs(fingers[:, 1]) > np.abs(fingers[:, 0])).mean() > 0.65


def test_free_hands_stand_across_the_section_or_come_along_it(floating_bar, hand):
    X_WH = proposed(floating_bar, "free")
    approach_H, closing_H = approach_axes(hand)
    approach, closing = X_WH[:, :3, :3] @ approach_H, X_WH[:, :3, :3] @ closing_H
    assert len(X_WH) > 20
    across = np.abs(approach[:, 1]) < 0.1
    assert across.mean() > 0.5
    np.testing.assert_allclose(closing[across, 1], 0, atol=0.1)
    np.testing.assert_allclose(np.abs(approach[~across, 1]), 1, atol=0.1)


def test_a_ball_is_taken_from_everywhere(hand, table, standing):
    ball = standing(trimesh.creation.icosphere(subdivisions=3, radius=0.035))
    X_WH = proposed(make_site(ball, table, hand, SETTINGS, 0), "collect")
    headings = np.arctan2(X_WH[:, 1, 2], X_WH[:, 0, 2])
    assert (np.histogram(headings, 6, (-np.pi, np.pi))[0] > 0).all()
    approach = (
        proposed(make_site(ball, Plane(), hand, SETTINGS, 0), "free")[:, :3, :3]
        @ approach_axes(hand)[0]
    )
    assert np.linalg.norm(approach.mean(axis=0)) < 0.3
