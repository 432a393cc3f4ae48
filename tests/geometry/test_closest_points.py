import numpy as np
import pytest
import trimesh

from vh_drake.geometry.closest_points import (
    closest_faces,
    closest_point,
    closest_points,
    triangle_tree,
)
from vh_drake.geometry.meshes import TriMesh, from_trimesh
from vh_drake.geometry.signed_distance import distance_to_surface


def torus():
    return from_trimesh(trimesh.creation.torus(0.05, 0.015))


def test_nearest_points_are_as_far_as_the_exact_distance_says():
    mesh = torus()
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (300, 3))
    nearest = closest_points(triangle_tree(mesh), points)
    distance = np.linalg.norm(nearest - points, axis=1)
    np.testing.assert_allclose(distance, distance_to_surface(mesh, points), atol=1e-12)


def test_nearest_points_lie_on_the_mesh():
    mesh = torus()
    points = np.random.default_rng(1).normal(0, 0.05, (100, 3))
    nearest = closest_points(triangle_tree(mesh), points)
    np.testing.assert_allclose(distance_to_surface(mesh, nearest), 0.0, atol=1e-9)


def test_nearest_points_lie_in_the_planes_of_their_faces_and_inside_them():
    mesh = torus()
    points = np.random.default_rng(3).normal(0, 0.05, (100, 3))
    nearest, faces = closest_faces(triangle_tree(mesh), points)
    corners = mesh.triangles[faces]
    height = np.einsum("ij,ij->i", nearest - corners[:, 0], mesh.face_normals[faces])
    np.testing.assert_allclose(height, 0.0, atol=1e-9)
    shares = trimesh.triangles.points_to_barycentric(corners, nearest)
    assert shares.min() > -1e-6


def test_a_rigid_motion_moves_the_nearest_points_along():
    mesh, rng = torus(), np.random.default_rng(2)
    points = rng.uniform(-0.1, 0.1, (50, 3))
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = np.linalg.qr(rng.normal(size=(3, 3)))[0], [0.3, -0.2, 0.1]
    moved = closest_points(triangle_tree(mesh.transformed(X)), points @ X[:3, :3].T + X[:3, 3])
    still = closest_points(triangle_tree(mesh), points)
    np.testing.assert_allclose(moved, still @ X[:3, :3].T + X[:3, 3], atol=1e-9)


def test_what_is_farther_than_the_limit_is_not_found():
    tree = triangle_tree(torus())
    assert closest_point(tree, (0.0, 0.0, 0.0), 0.02)[0] == pytest.approx(0.02)
    assert closest_point(tree, (0.0, 0.0, 0.0), 0.05)[0] == pytest.approx(0.035, abs=1e-3)


def test_triangles_without_area_do_no_harm():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    mesh = TriMesh(vertices, np.array([[0, 1, 2], [0, 0, 0]]))
    nearest = closest_points(triangle_tree(mesh), np.array([[1.5, 1.0, 0.0], [-1.0, 0, 0]]))
    np.testing.assert_allclose(nearest, [[1.5, 0, 0], [0, 0, 0]], atol=1e-12)
