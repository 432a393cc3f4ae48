import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.grasping.field import object_field
from vh_drake.types import Surface


def test_the_field_of_a_box_has_its_centre_and_size(standing, table):
    field = object_field(standing(trimesh.creation.box([0.06, 0.1, 0.04])), table)
    np.testing.assert_allclose(field.center, [0.7, -0.3, 0.92], atol=1e-3)
    assert field.size_m == pytest.approx(np.linalg.norm([0.03, 0.05, 0.02]), abs=1e-3)
    assert field.distance.values.min() == pytest.approx(-0.02, abs=0.002)


def test_the_centre_of_mass_is_in_the_heavier_half(standing, table):
    cone = trimesh.creation.cone(radius=0.04, height=0.12)
    field = object_field(standing(cone), table)
    np.testing.assert_allclose(field.center, [0.7, -0.3, 0.93], atol=2e-3)


def test_an_empty_surface_has_no_field(table):
    with pytest.raises(BadInput, match="empty"):
        object_field(Surface(), table)


def test_a_surface_with_nan_is_refused(standing, table):
    surface = standing(trimesh.creation.box([0.06, 0.1, 0.04]))
    surface.vertices[0] = np.nan
    with pytest.raises(BadInput, match="not finite"):
        object_field(surface, table)


def test_a_flat_surface_encloses_nothing(table):
    triangle = np.array([[0.0, 0, 1], [0.1, 0, 1], [0, 0.1, 1]])
    with pytest.raises(BadInput, match="encloses no node"):
        object_field(Surface(triangle, np.array([[0, 1, 2]])), table)
