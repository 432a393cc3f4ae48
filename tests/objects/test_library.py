import time

import numpy as np
import pytest

from vh_drake.errors import UnknownName
from vh_drake.geometry.signed_distance import distance_to_surface
from vh_drake.objects.library import library_names, library_object

SIDES_MM = {
    "apple": (75, 75, 59),
    "ball": (55, 55, 55),
    "banana": (184, 70, 39),
    "bottle": (64, 64, 202),
    "can": (67, 67, 101),
    "gelatin_box": (85, 73, 28),
    "hammer": (313, 97, 29),
    "mug": (112, 82, 90),
    "power_drill": (197, 62, 193),
    "shampoo": (72, 43, 175),
    "spray_bottle": (100, 63, 230),
    "sugar_box": (92, 45, 176),
}


def test_the_library_holds_the_kinds_of_the_thesis():
    assert len(library_names()) >= 14
    assert {"apple", "ball", "gelatin_box", "bottle", "shampoo", "spray_bottle"} <= set(
        library_names()
    )
    assert {"cereal_box", "can", "mug", "banana", "power_drill", "hammer"} <= set(library_names())


@pytest.mark.parametrize("name", library_names())
def test_every_object_is_a_watertight_solid_of_plausible_weight(name):
    model = library_object(name)
    assert model.mesh.is_watertight
    assert 1500 <= len(model.mesh.faces) <= 6000
    assert model.mesh.bounds[0, 2] == pytest.approx(0.0, abs=1e-9)
    assert 150 < model.mass_kg / model.mesh.volume < 5000
    assert np.linalg.eigvalsh(model.inertia).min() > 0
    assert (np.abs(model.mesh.bounds.mean(axis=0)[:2]) < 0.06).all()


@pytest.mark.parametrize("name", sorted(SIDES_MM))
def test_objects_have_their_real_sizes(name):
    sides = library_object(name).mesh.extents * 1e3
    np.testing.assert_allclose(sides, SIDES_MM[name], atol=1.0)


@pytest.mark.parametrize("name", ["mug", "power_drill", "spray_bottle"])
def test_building_takes_little_time_and_gives_the_same_bytes(name):
    start = time.process_time()
    again = library_object.__wrapped__(name)
    assert time.process_time() - start < 5.0
    np.testing.assert_array_equal(again.mesh.vertices, library_object(name).mesh.vertices)


def test_a_mug_is_hollow_and_its_wall_is_4_mm_thick():
    mug = library_object("mug").mesh
    assert distance_to_surface(mug, np.array([[0.0, 0.0, 0.05]]))[0] == pytest.approx(
        0.037, abs=1e-3
    )
    assert distance_to_surface(mug, np.array([[0.0, 0.039, 0.05]]))[0] == pytest.approx(
        0.002, abs=5e-4
    )


def test_an_unknown_name_lists_the_choices():
    with pytest.raises(UnknownName, match="banana"):
        library_object("bananna")
