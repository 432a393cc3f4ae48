import numpy as np
import pytest
import trimesh

from vh_drake.geometry.glyphs import arrows, balls, cones, joined, tube

RED = np.array([[1.0, 0.0, 0.0]])


def solid(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces)


def test_arrow_reaches_from_its_place_along_its_direction():
    p, n = np.array([[0.1, 0.2, 0.3]]), np.array([[0.6, 0.0, 0.8]])
    mesh = arrows(p, n, RED, length=0.05, radius=0.002)
    along = (mesh.vertices - p) @ n[0]
    assert along.min() == pytest.approx(0.0, abs=1e-12)
    assert along.max() == pytest.approx(0.05)


def test_faces_of_arrows_and_balls_look_outwards():
    p, n = np.zeros((1, 3)), np.array([[0.0, -1.0, 0.0]])
    assert solid(arrows(p, n, RED, length=0.05, radius=0.002)).volume > 0
    assert solid(balls(p, RED, radius=0.01)).volume > 0


def test_ball_has_its_radius_around_its_place():
    p = np.array([[1.0, 2.0, 3.0]])
    mesh = balls(p, RED, radius=0.01)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices - p, axis=1), 0.01)


def test_tube_stays_within_its_radius_of_the_line_and_skips_pieces_without_length():
    p = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 1, 0]])
    mesh = tube(p, RED[0], radius=0.1)
    assert np.isfinite(mesh.vertices).all()
    x, y, z = mesh.vertices.T
    to_first = np.hypot(np.hypot(y, z), np.maximum(x - 1, 0))
    to_second = np.hypot(np.hypot(x - 1, z), np.maximum(-y, 0))
    assert np.minimum(to_first, to_second).max() < 0.1 + 1e-9


def test_each_copy_keeps_its_own_colour():
    p = np.array([[0.0, 0, 0], [5, 0, 0]])
    mesh = balls(p, np.eye(3)[:2], radius=0.1)
    far = mesh.vertices[:, 0] > 2.5
    np.testing.assert_array_equal(mesh.colors[far], np.tile([0.0, 1, 0], (far.sum(), 1)))


def test_joined_faces_refer_to_the_vertices_of_their_own_part():
    parts = [balls(np.full((1, 3), x), RED, radius=0.1) for x in (0.0, 9.0)]
    mesh = joined(parts)
    assert np.ptp(mesh.vertices[mesh.faces], axis=1).max() < 0.3


def test_nothing_joined_is_an_empty_mesh():
    assert [len(part) for part in joined([])] == [0, 0, 0]


def test_a_cone_stands_on_its_point_and_opens_by_its_slope():
    p, n = np.array([[0.1, 0.2, 0.3]]), np.array([[0.6, 0.0, 0.8]])
    mesh = cones(p, n, RED, length=0.02, slope=0.8)
    along = (mesh.vertices - p) @ n[0]
    across = np.linalg.norm(mesh.vertices - p - along[:, None] * n, axis=1)
    rim = across > 1e-9
    np.testing.assert_allclose(across[rim], 0.8 * along[rim])
    np.testing.assert_allclose(along[rim], 0.02)
    assert np.abs(along[~rim]).min() < 1e-12
    assert solid(mesh).volume > 0
