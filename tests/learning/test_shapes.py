import numpy as np
import pytest

from vh_drake.errors import UnknownName
from vh_drake.geometry.signed_distance import distance_to_surface
from vh_drake.learning.shapes import shape_mesh, shape_names


@pytest.mark.parametrize("name", shape_names(10))
def test_drawn_shapes_are_solids_of_a_size_that_a_hand_can_meet(name):
    mesh = shape_mesh(name)
    assert mesh.is_watertight
    assert mesh.volume > 1e-5
    assert 0.03 < mesh.extents.max() < 0.3


def test_a_name_always_gives_the_same_shape_and_numbers_differ():
    first, again, other = (shape_mesh(f"shape_lathe_{n}") for n in ("03", "03", "04"))
    np.testing.assert_array_equal(first.vertices, again.vertices)
    assert distance_to_surface(other, first.vertices).max() > 0.003


def test_names_take_all_kinds_in_turn():
    names = shape_names(20)
    assert len(set(names)) == 20
    assert len({name.split("_")[1] for name in names[:10]}) == 10


def test_an_unknown_shape_lists_the_kinds():
    with pytest.raises(UnknownName, match="shape_box_00"):
        shape_mesh("shape_teapot_00")
