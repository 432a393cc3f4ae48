import numpy as np
import pytest
import trimesh

from vh_drake.gpis.meshing import closed_mesh
from vh_drake.types import ScalarGrid


def grid_of(field, low=-1.0, high=1.0, spacing=0.05):
    axis = np.arange(low, high + spacing / 2, spacing)
    nodes = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    return ScalarGrid(np.full(3, low), spacing, field(nodes))


def ball(centre, radius):
    return lambda x: np.linalg.norm(x - np.asarray(centre), axis=-1) - radius


def test_mesh_of_a_ball_has_its_volume_and_radial_normals():
    vertices, faces, normals = closed_mesh(grid_of(ball((0, 0, 0), 0.6)), np.array([[0.6, 0, 0]]))
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 0.6**3, rel=0.01)
    radial = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", normals, radial).min() > 0.98


def test_sheets_without_data_and_cavities_are_dropped():
    shell = lambda x: np.maximum(ball((-0.4, 0, 0), 0.5)(x), -ball((-0.4, 0, 0), 0.2)(x))  # noqa: E731
    both = grid_of(lambda x: np.minimum(shell(x), ball((0.7, 0.7, 0.7), 0.2)(x)))
    vertices, faces, _ = closed_mesh(both, np.array([[-0.9, 0, 0], [-0.4, 0, 0.5]]))
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.body_count == 1
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 0.5**3, rel=0.02)


def test_solid_that_leaves_the_grid_is_closed_at_its_border():
    vertices, faces, _ = closed_mesh(grid_of(lambda x: x[..., 2]), np.zeros((1, 3)))
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(4.0, rel=0.2)


def test_nothing_solid_gives_an_empty_mesh():
    vertices, faces, normals = closed_mesh(grid_of(ball((0, 0, 0), -1.0)), np.zeros((1, 3)))
    assert len(vertices) == len(faces) == len(normals) == 0
