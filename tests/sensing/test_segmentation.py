import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree
from trimesh.creation import box, cylinder, icosphere
from trimesh.proximity import closest_point_naive

from vh_drake.errors import NothingSeen
from vh_drake.sensing.segmentation import SegmentationSettings, segment
from vh_drake.types import Cloud

sys.path.insert(0, str(Path(__file__).parent))
from synthetic_views import TABLE_Z, camera_pose, on_table, table, view

OBJECTS = {
    "box": box((0.175, 0.09, 0.045)),
    "thin box": box((0.12, 0.05, 0.02)),
    "bar": box((0.18, 0.03, 0.025)),
    "cereal box": box((0.16, 0.06, 0.21)),
    "can": cylinder(0.034, 0.102),
    "ball": icosphere(2, 0.035),
}
# Median and mean error of the normals [deg]: edges are rounded, so small things err more.
NORMAL_ERROR = {"box": (5, 10), "thin box": (6, 13), "bar": (9, 16), "cereal box": (3, 8),
                "can": (6, 10), "ball": (8, 9)}  # fmt: skip


@cache
def scene(name: str) -> tuple[trimesh.Trimesh, Cloud]:
    target = on_table(OBJECTS[name])
    return target, view([table(), target])


@pytest.mark.parametrize("name", OBJECTS)
def test_the_visible_surface_is_found_and_little_else(name):
    target, cloud = scene(name)
    seen = segment(cloud)
    clean = view([table(), target], seed=None).p_WC
    clean = clean[np.abs(clean[:, :2] - [0.7, -0.3]).max(axis=1) < 0.15]
    visible = clean[clean[:, 2] > TABLE_Z + 0.008]
    recall = np.mean(cKDTree(seen.p_WO).query(visible)[0] < 0.006)
    distance = closest_point_naive(target, seen.p_WO[::5])[1]
    assert recall > 0.96
    assert np.mean(distance > 0.006) < 0.01
    assert np.median(distance) < 0.0006
    assert abs(seen.table.offset - TABLE_Z) < 0.0006
    assert np.rad2deg(np.arccos(seen.table.normal[2])) < 0.1


@pytest.mark.parametrize("name", OBJECTS)
def test_normals_are_right_and_face_the_camera(name):
    target, cloud = scene(name)
    seen = segment(cloud)
    face = closest_point_naive(target, seen.p_WO[::5])[2]
    cosine = np.abs(np.einsum("ij,ij->i", target.face_normals[face], seen.n_WO[::5]))
    error = np.rad2deg(np.arccos(np.clip(cosine, 0.0, 1.0)))
    median, mean = NORMAL_ERROR[name]
    assert np.median(error) < median
    assert np.mean(error) < mean
    np.testing.assert_allclose(np.linalg.norm(seen.n_WO, axis=1), 1.0)
    to_camera = seen.p_WCamera - seen.p_WO
    assert np.all(np.einsum("ij,ij->i", seen.n_WO, to_camera) >= 0.0)


def test_the_robot_s_own_arm_is_not_the_object():
    arm = cylinder(
        0.05, 0.6, transform=trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0])
    )
    arm.apply_translation([0.35, -0.55, 1.0])
    target = on_table(OBJECTS["thin box"])
    seen = segment(view([table(), target, arm]))
    assert closest_point_naive(target, seen.p_WO[::5])[1].max() < 0.01


def test_the_expected_place_decides_between_two_objects():
    large, small = on_table(OBJECTS["box"], x=0.65), on_table(OBJECTS["can"], x=0.85, y=-0.1)
    cloud = view([table(), large, small])
    assert closest_point_naive(large, segment(cloud).p_WO[::5])[1].max() < 0.01
    near = SegmentationSettings(expected_place=[0.85, -0.1, 0.95])
    assert closest_point_naive(small, segment(cloud, near).p_WO[::5])[1].max() < 0.01


def test_the_same_cloud_gives_the_same_view_and_nan_points_change_nothing():
    _, cloud = scene("ball")
    first = segment(cloud)
    dirty = Cloud(
        np.vstack([cloud.p_WC, np.full((50, 3), np.nan), np.full((9, 3), np.inf)]),
        cloud.p_WCamera,
        cloud.n_WFrustum,
    )
    np.testing.assert_array_equal(segment(cloud).p_WO, first.p_WO)
    np.testing.assert_array_equal(segment(dirty).p_WO, first.p_WO)


@pytest.mark.parametrize(
    ("cloud", "message"),
    [
        (Cloud(), "0 of 0 points"),
        (Cloud(np.full((500, 3), np.nan)), r"0 of 500 points \(0 finite\)"),
        (Cloud(np.random.default_rng(0).uniform(-9, -8, (500, 3))), "widen the workspace"),
        (Cloud(np.tile([0.7, -0.3, 0.95], (500, 1))), "no table"),
    ],
)
def test_useless_clouds_are_refused_with_a_remedy(cloud, message):
    with pytest.raises(NothingSeen, match=message):
        segment(cloud)


def test_a_wall_is_no_table():
    rng = np.random.default_rng(0)
    wall = np.stack(
        [np.full(5000, 0.8), rng.uniform(-0.5, 0, 5000), rng.uniform(0.85, 1.3, 5000)], 1
    )
    with pytest.raises(NothingSeen, match="no table"):
        segment(Cloud(wall))


def test_an_empty_table_has_no_object():
    with pytest.raises(NothingSeen, match="no object on the table"):
        segment(view([table()]))


def test_an_object_that_the_image_cuts_off_is_out_of_view():
    target = on_table(OBJECTS["box"], x=0.66, y=-0.55)
    with pytest.raises(NothingSeen, match="out of view"):
        segment(view([table(), target], camera_pose()))


def test_an_object_at_the_edge_of_the_workspace_is_refused():
    settings = SegmentationSettings(workspace_max=[0.72, 0.15, 1.35])
    with pytest.raises(NothingSeen, match="out of the workspace"):
        segment(scene("box")[1], settings)
