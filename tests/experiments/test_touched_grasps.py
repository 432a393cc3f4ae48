import dataclasses as dc

import numpy as np
import pytest
import trimesh
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from vh_drake.catalog import Options
from vh_drake.experiments import figure_3_23, figure_3_25, touched_grasps
from vh_drake.experiments.grasp_gallery import scale_bar
from vh_drake.experiments.hand_picture import FINGERS, THUMB, hand_mesh
from vh_drake.experiments.reconstruction import compare
from vh_drake.experiments.touched_grasps import planned, shown, touched_object
from vh_drake.exploration.loop import EndSettings
from vh_drake.geometry.closest_points import closest_points, triangle_tree
from vh_drake.geometry.meshes import TriMesh
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import DEFAULT_HAND, hand_file, shipped_hands


@pytest.fixture(scope="module", autouse=True)
def few():
    """Few touches and candidates, for speed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(touched_grasps, "CANDIDATES", 20)
        patch.setattr(touched_grasps, "END", EndSettings(goal=0.7))
        yield


@pytest.fixture(scope="module")
def touched():
    return touched_object("can", 0)


@pytest.fixture(scope="module")
def plan(touched):
    return planned(touched, read_hand_model(load_hand(hand_file(DEFAULT_HAND))), "surface", 0)


@pytest.mark.parametrize("name", sorted(shipped_hands()))
def test_a_drawn_hand_reaches_as_far_as_its_spheres_do(name):
    hand = read_hand_model(load_hand(hand_file(name)))
    X_WH = np.eye(4)
    X_WH[:3, :3] = Rotation.random(random_state=3).as_matrix()
    X_WH[:3, 3] = [0.1, -0.2, 0.3]
    mesh = hand_mesh(hand, hand.upper, X_WH)
    centers, radii = hand.spheres(hand.upper)
    reach = centers @ X_WH[:3, :3].T + X_WH[:3, 3]
    for direction in np.random.default_rng(0).normal(size=(20, 3)):
        u = direction / np.linalg.norm(direction)
        farthest = (reach @ u + radii).max()
        assert farthest - 0.002 < (mesh.vertices @ u).max() < farthest + 1e-9
    assert trimesh.Trimesh(mesh.vertices, mesh.faces).is_winding_consistent


def test_the_thumb_of_a_drawn_hand_stands_out(plan):
    hand = plan.hand
    mesh = hand_mesh(hand, hand.lower, np.eye(4))
    thumb = (mesh.colors == to_rgb(THUMB)).all(axis=1)
    fingers = (mesh.colors == to_rgb(FINGERS)).all(axis=1)
    along = np.asarray(hand.description.along)
    assert (mesh.vertices[thumb] @ along).max() < (mesh.vertices[fingers] @ along).min()


def test_a_touched_surface_lies_near_the_object(touched):
    surface = touched.surface
    errors = compare(TriMesh(surface.vertices, surface.faces), touched.truth)
    assert errors.distance_m < 0.006
    assert trimesh.Trimesh(surface.vertices, surface.faces).is_watertight
    assert len(touched.contacts) >= 10


def test_stable_candidates_touch_the_estimate_and_come_best_first(plan):
    assert len(plan.stable) >= 3
    assert (np.diff(plan.epsilon[plan.stable]) <= 0).all()
    surface = plan.touched.surface
    tree = triangle_tree(TriMesh(surface.vertices, surface.faces))
    for i in plan.stable:
        p = plan.closures[i].p_WC
        assert len(p) >= 3
        assert np.linalg.norm(closest_points(tree, p) - p, axis=1).max() < 0.002


def test_what_is_drawn_is_stable_and_not_twice_the_same(plan):
    drawn = shown(plan, 3)
    assert len(set(drawn.tolist())) == len(drawn) == min(3, len(plan.stable))
    assert (plan.epsilon[drawn] > 0).all()
    nothing = dc.replace(plan, epsilon=np.zeros(len(plan.epsilon)))
    assert len(shown(nothing, 3)) == 0


def test_the_bar_of_a_picture_is_five_centimetres_long_and_level_in_the_view():
    p = np.random.default_rng(0).normal(size=(50, 3))
    elevation, azimuth = 0.6, 2.0
    bar = scale_bar(p, elevation, azimuth).vertices
    view = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)])
    view = np.append(view, np.sin(elevation))
    right = np.cross([0.0, 0.0, 1.0], view) / np.cos(elevation)
    up = np.cross(view, right)
    assert np.ptp(bar @ right) == pytest.approx(0.05)
    assert np.ptp(bar @ up) < 0.004
    assert (bar @ up).max() < (p @ up).min()


def test_figure_3_23_writes_picture_and_rows(monkeypatch, tmp_path):
    monkeypatch.setattr(figure_3_23, "OBJECT", "can")
    report = figure_3_23.run(Options(out=tmp_path))
    assert (tmp_path / "figure-3.23.png").stat().st_size > 20_000
    assert report.summary["candidates"] == len(report.rows) == 20
    assert {row["planner"] for row in report.rows} == {"surface"}


def test_figure_3_25_has_both_hands_and_both_planners():
    hands = ("armar3_right", "armar6_right")
    plans = figure_3_25.plan_all(("can",), hands, 0)
    pairs = [(plan.hand.description.name, plan.planner) for plan in plans]
    assert pairs == [(hand, planner) for hand in hands for planner in ("surface", "skeleton")]
    figure = Figure()
    figure_3_25.draw_plans(figure, plans, 2)
    assert len(figure.axes) == 4
