import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh, concatenate, from_trimesh
from vh_drake.geometry.repair import boundary_loops, repair_mesh
from vh_drake.objects.library import library_object


@pytest.fixture
def ball() -> TriMesh:
    return from_trimesh(trimesh.creation.icosphere(3, 0.04))


def test_a_sound_mesh_is_left_as_it_is(ball):
    repaired = repair_mesh(ball)
    assert repaired.report == ()
    assert repaired.mesh.volume == pytest.approx(ball.volume)


def test_loose_triangles_are_joined(ball):
    soup = TriMesh(ball.triangles.reshape(-1, 3), np.arange(3 * len(ball.faces)).reshape(-1, 3))
    repaired = repair_mesh(soup)
    assert repaired.mesh.is_watertight
    assert len(repaired.mesh.vertices) == len(ball.vertices)
    assert "duplicate vertices" in repaired.report[0]


def test_degenerate_and_duplicate_faces_are_dropped(ball):
    extra = np.array([[0, 0, 1], ball.faces[5]])
    repaired = repair_mesh(TriMesh(ball.vertices, np.vstack([ball.faces, extra])))
    assert len(repaired.mesh.faces) == len(ball.faces)
    assert "2 degenerate" in repaired.report[0]


def test_an_inverted_mesh_is_turned_outward(ball):
    repaired = repair_mesh(ball.flipped())
    assert repaired.mesh.volume == pytest.approx(ball.volume)
    assert "outward" in repaired.report[0]


def test_mixed_windings_are_aligned(ball):
    faces = ball.faces.copy()
    faces[::3] = faces[::3, ::-1]
    repaired = repair_mesh(TriMesh(ball.vertices, faces))
    assert repaired.mesh.is_watertight
    assert repaired.mesh.volume == pytest.approx(ball.volume)


def test_small_holes_are_closed(ball):
    keep = np.ones(len(ball.faces), bool)
    keep[[10, 200, 600]] = False
    repaired = repair_mesh(ball.with_faces(keep))
    assert repaired.mesh.is_watertight
    assert repaired.mesh.volume == pytest.approx(ball.volume, rel=1e-3)
    assert repaired.report == ("Closed 3 holes.",)


def test_a_box_without_bottom_gets_one():
    box = from_trimesh(trimesh.creation.box((0.1, 0.1, 0.1)).subdivide())
    repaired = repair_mesh(box.with_faces(box.face_normals[:, 2] > -0.5))
    assert repaired.mesh.volume == pytest.approx(1e-3)


def test_an_open_sheet_is_thickened_and_stays_open(ball):
    lower = ball.with_faces(ball.triangles[:, :, 2].max(axis=1) < 0.001)
    repaired = repair_mesh(lower)
    assert repaired.mesh.is_watertight
    assert 0 < repaired.mesh.volume < 0.5 * repaired.mesh.convex_hull.volume
    assert "Thickened" in repaired.report[-1]


def test_a_mesh_full_of_holes_is_rebuilt_near_its_old_shape(ball):
    keep = np.random.default_rng(0).random(len(ball.faces)) < 0.7
    repaired = repair_mesh(ball.with_faces(keep))
    assert repaired.mesh.is_watertight
    assert repaired.mesh.volume == pytest.approx(ball.volume, rel=0.1)


def test_a_concavity_survives_rebuilding():
    mug = library_object("mug").mesh
    faces = np.vstack([mug.faces, mug.faces[:40] * [1, 1, 0]])  # fins that tear the surface
    repaired = repair_mesh(TriMesh(mug.vertices, faces))
    assert repaired.mesh.is_watertight
    assert repaired.mesh.volume < 0.5 * repaired.mesh.convex_hull.volume


def test_specks_are_dropped(ball):
    repaired = repair_mesh(concatenate([ball, ball.scaled(0.01)]))
    assert len(repaired.mesh.faces) == len(ball.faces)
    assert repaired.report == ("Dropped 1 loose specks.",)


def test_a_cavity_stays_a_cavity(ball):
    hollow = concatenate([ball, ball.scaled(0.5).flipped()])
    assert repair_mesh(hollow).mesh.volume == pytest.approx(0.875 * ball.volume)


def test_a_point_of_triangles_is_refused():
    with pytest.raises(BadInput, match="one point"):
        repair_mesh(TriMesh(np.ones((3, 3)), np.array([[0, 1, 2]])))


def test_only_degenerate_triangles_are_refused():
    with pytest.raises(BadInput, match="degenerate"):
        repair_mesh(TriMesh(np.eye(3), np.array([[0, 0, 1], [1, 2, 2]])))


def test_boundary_loops_find_each_closed_chain():
    edges = np.array([[0, 1], [5, 6], [1, 2], [6, 5], [2, 0], [8, 9]])
    loops = [loop.tolist() for loop in boundary_loops(edges)]
    assert loops == [[0, 1, 2], [5, 6]]
