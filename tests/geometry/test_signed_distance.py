import numpy as np
import pytest
import trimesh
from scipy.optimize import minimize

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import from_trimesh
from vh_drake.geometry.signed_distance import (
    distance_to_surface,
    grid_around,
    interpolate,
    signed_distance_grid,
    winding_nodes,
)

BOX = from_trimesh(trimesh.creation.box((0.04, 0.06, 0.08)))


def box_distance(points):
    q = np.abs(points) - [0.02, 0.03, 0.04]
    return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(axis=-1), 0)


def nodes(grid):
    index = np.stack(np.meshgrid(*map(np.arange, grid.values.shape), indexing="ij"), axis=-1)
    return grid.origin + grid.spacing * index


def test_a_box_has_its_closed_form_distance_near_and_far():
    grid = signed_distance_grid(BOX, spacing=0.0027, padding=0.02)
    exact = box_distance(nodes(grid))
    near = np.abs(exact) < 2 * grid.spacing
    np.testing.assert_allclose(grid.values[near], exact[near], atol=1e-9)
    np.testing.assert_allclose(grid.values, exact, atol=grid.spacing / 2)


def test_the_grid_knows_the_inside_of_a_torus_from_its_hole():
    torus = from_trimesh(trimesh.creation.torus(0.04, 0.012, 96, 48))
    grid = signed_distance_grid(torus, spacing=0.002, padding=0.01)
    p = nodes(grid)
    exact = np.hypot(np.hypot(p[..., 0], p[..., 1]) - 0.04, p[..., 2]) - 0.012
    np.testing.assert_allclose(grid.values, exact, atol=5e-4)


def test_interpolation_reproduces_a_linear_field_and_its_gradient():
    grid = signed_distance_grid(BOX, spacing=0.004, padding=0.02)
    slope = np.array([0.3, -0.5, 0.8])
    linear = type(grid)(grid.origin, grid.spacing, nodes(grid) @ slope + 0.1)
    points = np.random.default_rng(0).uniform(-0.03, 0.03, (100, 3))
    values, gradients = interpolate(linear, points)
    np.testing.assert_allclose(values, points @ slope + 0.1, atol=1e-12)
    np.testing.assert_allclose(gradients, np.tile(slope, (100, 1)), atol=1e-9)


def test_gradients_match_finite_differences():
    grid = signed_distance_grid(BOX, spacing=0.004, padding=0.02)
    points = np.random.default_rng(1).uniform(-0.03, 0.03, (50, 3))
    _, gradients = interpolate(grid, points)
    for axis in range(3):
        step = np.eye(3)[axis] * 1e-8
        ahead, behind = interpolate(grid, points + step)[0], interpolate(grid, points - step)[0]
        np.testing.assert_allclose((ahead - behind) / 2e-8, gradients[:, axis], atol=1e-4)


def test_beyond_the_grid_the_distance_keeps_growing_outward():
    grid = signed_distance_grid(BOX, spacing=0.004, padding=0.01)
    points = np.array([[0.5, 0.0, 0.0], [0.0, -1.0, 0.0]])
    values, gradients = interpolate(grid, points)
    np.testing.assert_allclose(values, box_distance(points), atol=1e-3)
    np.testing.assert_allclose(gradients, [[1, 0, 0], [0, -1, 0]], atol=1e-9)


def test_point_distance_agrees_with_a_numerical_minimisation():
    triangle = from_trimesh(trimesh.Trimesh([[0, 0, 0], [1, 0.1, 0], [0.3, 0.9, 0.4]], [[0, 1, 2]]))
    a, b, c = triangle.vertices
    for p in np.random.default_rng(3).uniform(-1, 2, (20, 3)):
        found = minimize(
            lambda w, p=p: ((a + w[0] * (b - a) + w[1] * (c - a) - p) ** 2).sum(),
            [0.3, 0.3],
            bounds=[(0, 1), (0, 1)],
            constraints={"type": "ineq", "fun": lambda w: 1 - w.sum()},
            method="SLSQP",
            options={"ftol": 1e-14},
        )
        assert distance_to_surface(triangle, p[None])[0] == pytest.approx(
            np.sqrt(found.fun), abs=1e-5
        )


def test_a_triangle_without_area_measures_like_a_segment():
    mesh = from_trimesh(
        trimesh.Trimesh([[0, 0, 0], [2, 0, 0], [1, 0, 0]], [[0, 1, 2]], process=False)
    )
    distances = distance_to_surface(mesh, np.array([[1.0, 3.0, 4.0], [-3.0, 4.0, 0.0]]))
    np.testing.assert_allclose(distances, [5.0, 5.0])


def test_winding_votes_survive_a_hole():
    opened = BOX.with_faces(np.arange(11))
    origin, shape = grid_around(opened, spacing=0.004, padding=0.01)
    votes = winding_nodes((opened.triangles - origin) / 0.004, shape) >= 0.5
    truth = winding_nodes((BOX.triangles - origin) / 0.004, shape) >= 0.5
    np.testing.assert_array_equal(votes, truth)


@pytest.mark.parametrize(
    ("spacing", "padding"), [(0.0, 0.1), (-1.0, 0.1), (0.01, -0.1), (1e-6, 0.1)]
)
def test_an_unusable_grid_is_refused(spacing, padding):
    with pytest.raises(BadInput):
        signed_distance_grid(BOX, spacing=spacing, padding=padding)
