import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh, from_trimesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.geometry.signed_distance import distance_to_surface

BOX = from_trimesh(trimesh.creation.box((0.1, 0.2, 0.4)))


def test_samples_lie_on_the_surface():
    points, _ = sample_surface(BOX, 500, seed=1)
    np.testing.assert_allclose(distance_to_surface(BOX, points), 0, atol=1e-12)


def test_faces_receive_samples_in_proportion_to_their_area():
    _, normals = sample_surface(BOX, 20_000, seed=0)
    share = np.abs(normals).mean(axis=0)
    area = np.array([0.2 * 0.4, 0.1 * 0.4, 0.1 * 0.2])
    np.testing.assert_allclose(share, area / area.sum(), atol=0.012)


def test_normals_point_outward():
    points, normals = sample_surface(BOX, 200, seed=2)
    assert (np.einsum("ni,ni->n", points, normals) > 0).all()


def test_the_same_seed_gives_the_same_points():
    first, second = sample_surface(BOX, 50, seed=7)[0], sample_surface(BOX, 50, seed=7)[0]
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, sample_surface(BOX, 50, seed=8)[0])


def test_a_mesh_without_area_is_refused():
    with pytest.raises(BadInput):
        sample_surface(TriMesh(np.zeros((3, 3)), np.array([[0, 1, 2]])), 5, seed=0)
