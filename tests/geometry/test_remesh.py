import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import concatenate, from_trimesh
from vh_drake.geometry.remesh import extract_surface, remesh, simplify
from vh_drake.geometry.signed_distance import distance_to_surface, signed_distance_grid
from vh_drake.types import ScalarGrid

BALL = from_trimesh(trimesh.creation.icosphere(4, 0.05))


def test_the_surface_of_a_distance_grid_is_the_original():
    grid = signed_distance_grid(BALL, spacing=0.002, padding=0.01)
    surface = extract_surface(grid)
    assert surface.is_watertight
    assert distance_to_surface(BALL, surface.vertices).max() < 0.2 * grid.spacing
    assert surface.volume == pytest.approx(BALL.volume, rel=0.01)


def test_a_solid_that_leaves_the_grid_is_closed_at_its_border():
    values = np.full((5, 5, 5), -0.01)
    surface = extract_surface(ScalarGrid(np.zeros(3), 0.01, values))
    assert surface.is_watertight
    assert surface.volume > 0


def test_a_field_without_inside_is_refused():
    with pytest.raises(BadInput):
        extract_surface(ScalarGrid(np.zeros(3), 0.01, np.ones((5, 5, 5))))


def test_overlapping_parts_become_one_solid():
    other = from_trimesh(trimesh.creation.icosphere(4, 0.05).apply_translation([0.05, 0, 0]))
    surface, sentence = remesh(concatenate([BALL, other]), nodes=80)
    overlap = np.pi * (4 * 0.05 + 0.05) * (2 * 0.05 - 0.05) ** 2 / 12
    assert surface.volume == pytest.approx(2 * BALL.volume - overlap, rel=0.02)
    assert "Rebuilt" in sentence


def test_simplifying_keeps_a_closed_surface_near_the_old_one():
    coarse = simplify(BALL, 300)
    assert coarse.is_watertight
    assert len(coarse.faces) <= 300
    assert distance_to_surface(BALL, coarse.vertices).max() < 1e-3


def test_a_mesh_that_is_coarse_enough_is_left_alone():
    assert simplify(BALL, 10_000) is BALL
