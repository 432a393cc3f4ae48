import numpy as np
import pytest
import trimesh

from vh_drake.geometry.inertia import mass_properties
from vh_drake.geometry.meshes import TriMesh, from_trimesh
from vh_drake.geometry.stable_poses import draw_pose, stable_poses
from vh_drake.objects.library import library_object

SIDES = (0.05, 0.08, 0.12)


@pytest.fixture
def box() -> TriMesh:
    mesh = from_trimesh(trimesh.creation.box(SIDES).subdivide())
    return TriMesh(mesh.vertices + np.array([0.3, -0.2, 0.1]), mesh.faces)


def test_a_box_rests_on_each_of_its_six_faces(box):
    rests = stable_poses(box)
    assert len(rests) == 6
    assert sum(rest.probability for rest in rests) == pytest.approx(1.0)
    heights = sorted(np.ptp(box.transformed(rest.X_WO).vertices[:, 2]) for rest in rests)
    np.testing.assert_allclose(heights, np.repeat(SIDES, 2), atol=1e-9)


def test_resting_objects_touch_the_plane_below_their_centre_of_mass(box):
    for rest in stable_poses(box):
        moved = box.transformed(rest.X_WO)
        assert moved.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-12)
        np.testing.assert_allclose(mass_properties(moved, 1.0).com[:2], 0.0, atol=1e-12)
        assert np.linalg.det(rest.X_WO[:3, :3]) == pytest.approx(1.0)


def test_probabilities_agree_with_trimesh():
    mesh = library_object("power_drill").mesh
    ours = np.sort([rest.probability for rest in stable_poses(mesh)])[::-1]
    _, peer = trimesh.poses.compute_stable_poses(mesh.to_trimesh(), sigma=0.0, threshold=0.02)
    np.testing.assert_allclose(ours[: len(peer)], np.sort(peer)[::-1], atol=0.01)


def test_the_side_of_a_can_is_one_group():
    rests = stable_poses(library_object("can").mesh)
    assert len({rest.group for rest in rests}) == 3


def test_a_body_does_not_rest_where_its_centre_of_mass_can_still_sink():
    mesh = library_object("mug").mesh
    com = library_object("mug").com
    for rest in stable_poses(mesh):
        if rest.probability < 0.02:
            continue
        height = (rest.X_WO[:3, :3] @ com)[2] + rest.X_WO[2, 3]
        for axis in np.vstack([np.eye(3)[:2], -np.eye(3)[:2]]):
            tilt = trimesh.transformations.rotation_matrix(0.03, axis)
            turned = tilt[:3, :3] @ rest.X_WO[:3, :3]
            assert (turned @ com)[2] - (mesh.vertices @ turned[2]).min() > height - 2e-4


def test_a_drawn_pose_stands_on_the_table_and_depends_only_on_the_seed(box):
    X = draw_pose(box, seed=5)
    np.testing.assert_array_equal(X, draw_pose(box, seed=5))
    assert box.transformed(X).vertices[:, 2].min() == pytest.approx(0.0, abs=1e-12)


def test_drawn_poses_follow_the_probabilities_and_all_yaws(box):
    poses = np.array([draw_pose(box, seed=seed) for seed in range(150)])
    flat = np.mean([np.ptp(box.transformed(X).vertices[:, 2]) < 0.06 for X in poses])
    expected = 2 * max(rest.probability for rest in stable_poses(box))
    assert flat == pytest.approx(expected, abs=0.12)
    lying = poses[np.abs(poses[:, 2, 2]) < 0.5]
    yaw = np.arctan2(lying[:, 1, 2], lying[:, 0, 2])
    assert np.histogram(yaw, 4, (-np.pi, np.pi))[0].min() > 15


def test_a_ball_can_be_drawn_although_each_of_its_rests_is_rare():
    ball = library_object("ball").mesh
    assert ball.transformed(draw_pose(ball, seed=0)).vertices[:, 2].min() == pytest.approx(0.0)


def test_rare_rests_are_not_drawn():
    rod = from_trimesh(trimesh.creation.cylinder(0.005, 0.2))
    for seed in range(30):
        assert np.ptp(rod.transformed(draw_pose(rod, seed=seed)).vertices[:, 2]) < 0.02
