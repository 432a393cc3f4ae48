import numpy as np
import pytest
import trimesh

from vh_drake.geometry.meshes import TriMesh, concatenate, from_trimesh


@pytest.fixture
def torus() -> TriMesh:
    return from_trimesh(trimesh.creation.torus(0.04, 0.01))


def test_volume_of_a_box_is_the_product_of_its_sides():
    box = from_trimesh(trimesh.creation.box((0.1, 0.2, 0.3)))
    assert box.volume == pytest.approx(0.006)
    assert box.areas.sum() == pytest.approx(2 * (0.02 + 0.03 + 0.06))
    np.testing.assert_allclose(box.extents, [0.1, 0.2, 0.3])


def test_volume_and_area_agree_with_trimesh(torus):
    peer = torus.to_trimesh()
    assert torus.volume == pytest.approx(peer.volume)
    np.testing.assert_allclose(torus.face_normals, peer.face_normals, atol=1e-9)


def test_turning_inside_out_changes_the_sign_of_the_volume(torus):
    assert torus.flipped().volume == pytest.approx(-torus.volume)
    assert torus.flipped().is_watertight


def test_a_rigid_motion_keeps_volume_and_area(torus):
    X = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    X[:3, 3] = [0.3, -0.1, 2.0]
    moved = torus.transformed(X)
    assert moved.volume == pytest.approx(torus.volume)
    assert moved.areas.sum() == pytest.approx(torus.areas.sum())


def test_a_removed_face_leaves_its_three_edges_open(torus):
    opened = torus.with_faces(np.arange(1, len(torus.faces)))
    assert torus.is_watertight
    assert not opened.is_watertight
    assert len(opened.boundary_edges) == 3


def test_a_flipped_face_makes_a_mesh_not_watertight(torus):
    faces = torus.faces.copy()
    faces[0] = faces[0, ::-1]
    assert not TriMesh(torus.vertices, faces).is_watertight


def test_a_mesh_without_faces_is_not_watertight():
    assert not TriMesh(np.zeros((3, 3)), np.zeros((0, 3), np.int64)).is_watertight


def test_concatenated_volumes_add_up(torus):
    pair = concatenate([torus, torus.scaled(2.0)])
    assert pair.is_watertight
    assert pair.volume == pytest.approx(9 * torus.volume)


def test_the_hull_of_a_torus_is_larger_and_watertight(torus):
    assert torus.convex_hull.is_watertight
    assert torus.convex_hull.volume > torus.volume
