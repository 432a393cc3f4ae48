import math

import numpy as np
import pytest

from vh_drake.experiments.reconstruction import (
    Reconstruction,
    compare,
    with_normals,
    without_normals,
)
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.gpis.edges import EdgeSettings
from vh_drake.gpis.evidence import farthest_points
from vh_drake.objects import lathe


def ball_contacts(count=50, radius=0.05):
    n = np.random.default_rng(0).normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return radius * n + [0.0, 0.0, radius], n


def test_concentric_spheres_differ_by_their_radii_and_not_in_their_normals():
    inner, outer = lathe.sphere(0.05), lathe.sphere(0.053)
    moved = TriMesh(outer.vertices - [0.0, 0.0, 0.003], outer.faces)
    errors = compare(moved, inner)
    assert errors.distance_m == pytest.approx(0.003, rel=0.02)
    assert errors.angle_rad < math.radians(3)


def test_a_surface_does_not_differ_from_itself():
    errors = compare(lathe.box((0.1, 0.07, 0.05)), lathe.box((0.1, 0.07, 0.05)))
    assert errors.distance_m < 1e-9
    assert errors.angle_rad < math.radians(0.1)


def test_flat_faces_meet_in_edges():
    p, n = sample_surface(lathe.box((0.12, 0.06, 0.08)), 3000, seed=0)
    chosen = farthest_points(p, 60)
    rounded, sharp = (
        compare(
            with_normals(p[chosen], n[chosen], Reconstruction(edges=edges)),
            lathe.box((0.12, 0.06, 0.08)),
        )
        for edges in (None, EdgeSettings())
    )
    assert sharp.angle_rad < 0.8 * rounded.angle_rad
    assert sharp.distance_m < 0.8 * rounded.distance_m


def test_both_formulations_find_a_ball():
    p, n = ball_contacts()
    for estimate in (with_normals(p, n, Reconstruction()), without_normals(p, Reconstruction())):
        errors = compare(estimate, lathe.sphere(0.05))
        assert errors.distance_m < 0.001
        assert errors.angle_rad < math.radians(5)


def test_nothing_estimated_counts_with_the_size_of_the_object():
    nothing = TriMesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    errors = compare(nothing, lathe.box((0.1, 0.07, 0.05)))
    assert errors.distance_m == pytest.approx(np.linalg.norm([0.1, 0.07, 0.05]))
    assert errors.angle_rad == pytest.approx(math.pi / 2)
