import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.gpis.following import follow_surface
from vh_drake.gpis.inside_outside import icosahedron, inside_outside_observations, ring
from vh_drake.gpis.kernels import SquaredExponential, ThinPlate
from vh_drake.gpis.posterior import fit


def ball(count, seed=0, radius=0.05, centre=(0.3, -0.2, 0.1)):
    n = np.random.default_rng(seed).normal(size=(count, 3))
    return radius * n / np.linalg.norm(n, axis=1, keepdims=True) + np.asarray(centre)


def test_directions_are_unit_vectors_evenly_around():
    for directions in (icosahedron(), ring(8)):
        np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
        np.testing.assert_allclose(directions.sum(axis=0), 0.0, atol=1e-12)
    cosines = icosahedron() @ icosahedron().T - 2 * np.eye(12)
    np.testing.assert_allclose(cosines.max(axis=1), 1 / np.sqrt(5))


def test_contacts_are_zero_the_centre_negative_and_the_ring_positive():
    p = ball(30)
    seen = inside_outside_observations(p)
    assert not seen.has_gradient.any()
    np.testing.assert_array_equal(seen.value[:30], 0.0)
    np.testing.assert_allclose(seen.p[30], p.mean(axis=0))
    assert seen.value[30] < 0 < seen.value[31:].min()
    reach = np.linalg.norm(seen.p[31:] - seen.p[30], axis=1)
    assert reach.min() > np.linalg.norm(p - seen.p[30], axis=1).max()


@pytest.mark.parametrize("kernel", [ThinPlate(), SquaredExponential(0.06, 0.05)])
def test_positions_alone_find_a_ball(kernel):
    p = ball(60)
    sheet = follow_surface(fit(kernel, inside_outside_observations(p)), p)
    radius = np.linalg.norm(sheet.vertices - [0.3, -0.2, 0.1], axis=1)
    assert np.abs(radius - 0.05).mean() < 0.001
    outward = (sheet.vertices - [0.3, -0.2, 0.1]) / radius[:, None]
    assert np.einsum("ij,ij->i", sheet.normals, outward).mean() > 0.98


@pytest.mark.parametrize("p", [np.zeros((0, 3)), np.zeros((1, 3)), np.ones((3, 3))])
def test_a_single_place_is_refused(p):
    with pytest.raises(BadInput, match="at least two"):
        inside_outside_observations(p)
