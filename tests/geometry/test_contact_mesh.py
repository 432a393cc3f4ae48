import pytest
import trimesh

from vh_drake.geometry.contact_mesh import coarsen, surface_deviation
from vh_drake.geometry.meshes import from_trimesh
from vh_drake.objects.library import library_object


@pytest.mark.parametrize("name", ["mug", "power_drill", "banana", "hammer", "shampoo"])
def test_contact_meshes_are_coarse_closed_and_near(name):
    contact = library_object(name).contact
    assert contact.mesh.is_watertight
    assert len(contact.mesh.faces) <= 450
    assert contact.deviation_m < 0.0025


def test_a_mug_stays_hollow():
    mug = library_object("mug")
    assert mug.contact_mesh.volume < 0.4 * mug.mesh.convex_hull.volume


def test_deviation_of_concentric_balls_is_the_gap_between_them():
    inner = from_trimesh(trimesh.creation.icosphere(4, 0.05))
    assert surface_deviation(inner, inner.scaled(1.1)) == pytest.approx(0.005, rel=0.02)
    assert surface_deviation(inner, inner) == pytest.approx(0.0, abs=1e-12)


def test_a_mesh_that_tears_when_simplified_gets_a_hull_at_least():
    flakes = from_trimesh(
        trimesh.creation.box((0.1, 0.1, 1e-5)).subdivide().subdivide().subdivide()
    )
    assert coarsen(flakes, triangles=12).mesh.is_watertight
