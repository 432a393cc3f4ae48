import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.objects.distance_fields import (
    ball,
    chain,
    cone_capsule,
    cut,
    mesh_field,
    ring,
    rod,
    rounded_box,
    stretched,
    union,
)

LOW, HIGH = (-0.08, -0.08, -0.08), (0.08, 0.08, 0.08)
SOLIDS = {
    "ball": (ball((0, 0, 0), 0.05), 4 / 3 * np.pi * 0.05**3),
    "rod": (rod((0, 0, -0.05), (0, 0, 0.05), 0.03, edge=0.0002), np.pi * 0.03**2 * 0.1),
    "box": (rounded_box((0, 0, 0), (0.1, 0.06, 0.04), 0.0002), 0.1 * 0.06 * 0.04),
    "ring": (ring((0, 0, 0), 0.05, 0.015), 2 * np.pi**2 * 0.05 * 0.015**2),
    "capsule": (
        cone_capsule((0, 0, -0.03), (0, 0, 0.03), 0.02, 0.02),
        np.pi * 0.02**2 * 0.06 + 4 / 3 * np.pi * 0.02**3,
    ),
    "ellipsoid": (stretched(ball((0, 0, 0), 0.05), (1, 0.5, 1.2)), 0.6 * 4 / 3 * np.pi * 0.05**3),
    "shell": (
        cut(ball((0, 0, 0), 0.05), ball((0, 0, 0), 0.03)),
        4 / 3 * np.pi * (0.05**3 - 0.03**3),
    ),
}


@pytest.mark.parametrize("name", sorted(SOLIDS))
def test_meshed_fields_are_closed_and_have_the_closed_form_volume(name):
    field, volume = SOLIDS[name]
    mesh = mesh_field(field, LOW, HIGH)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume, rel=0.015)


def test_mesh_vertices_lie_on_the_zero_set():
    field = union(ball((0, 0, 0), 0.03), rod((0, 0, 0), (0, 0, 0.06), 0.01), blend=0.005)
    mesh = mesh_field(field, LOW, HIGH)
    lifted = mesh.vertices + np.array([0, 0, -0.03])  # the mesh stands on z = 0
    assert np.abs(field(lifted)).max() < 3e-4


def test_a_blend_only_adds_material():
    points = np.random.default_rng(0).uniform(-0.08, 0.08, (500, 3))
    parts = ball((0, 0, 0), 0.03), ball((0.04, 0, 0), 0.02)
    sharp, smooth = union(*parts)(points), union(*parts, blend=0.01)(points)
    assert (smooth <= sharp + 1e-12).all()
    assert (sharp - smooth).max() <= 0.01 / 4 + 1e-12


def test_a_chain_passes_through_its_points():
    field = chain([(0, 0, 0), (0.03, 0, 0), (0.03, 0.03, 0)], [0.01, 0.008, 0.006])
    values = field(np.array([[0, 0, 0], [0.03, 0, 0], [0.03, 0.03, 0]]))
    np.testing.assert_allclose(values, [-0.01, -0.008, -0.006], atol=1e-9)


def test_a_shape_beyond_its_box_is_refused():
    with pytest.raises(BadInput, match="beyond its box"):
        mesh_field(ball((0, 0, 0), 0.2), LOW, HIGH)
