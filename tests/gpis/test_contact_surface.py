import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.gpis.contact_surface import ContactNoise, ContactSurface
from vh_drake.gpis.kernels import SquaredExponential, ThinPlate

KERNELS = [ThinPlate(0.5, 0.5 / 6**0.5), SquaredExponential(0.06, 0.05)]
UP = np.array([[0.0, 0.0, 1.0]])


def ball(count, seed=0, radius=0.05):
    n = np.random.default_rng(seed).normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return radius * n, n


@pytest.mark.parametrize("kernel", KERNELS)
def test_contacts_appended_one_by_one_give_the_surface_of_all_together(kernel):
    p, n = ball(20)
    grown = ContactSurface.of(p[:1], n[:1], kernel=kernel)
    for i in range(1, 20):
        grown = grown.append(p[i], n[i])
    whole = ContactSurface.of(p, n, kernel=kernel)
    x = np.random.default_rng(1).uniform(-0.06, 0.06, (50, 3))
    np.testing.assert_allclose(grown.posterior.mean(x), whole.posterior.mean(x), atol=1e-10)
    np.testing.assert_allclose(grown.variance(x), whole.variance(x), atol=1e-10)
    assert len(grown) == 20


def test_imagined_contacts_leave_the_surface_as_it_was():
    surface = ContactSurface.of(*ball(10))
    x = np.random.default_rng(2).uniform(-0.06, 0.06, (50, 3))
    before = surface.posterior.mean(x)
    branches = [surface.append(*ball(1, seed)) for seed in range(1, 4)]
    np.testing.assert_array_equal(surface.posterior.mean(x), before)
    for seed, branch in enumerate(branches, start=1):
        alone = ContactSurface.of(*ball(10)).append(*ball(1, seed))
        np.testing.assert_array_equal(branch.posterior.mean(x), alone.posterior.mean(x))


def test_each_touch_lowers_the_variance_where_it_lands():
    surface = ContactSurface.of(*ball(5))
    p, n = ball(1, seed=3)
    assert surface.append(p, n).variance(p) < 0.1 * surface.variance(p)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize(
    ("p", "n"),
    [
        (np.zeros((1, 3)), UP),
        (np.zeros((3, 3)), np.repeat(UP, 3, axis=0)),
        (np.outer(np.arange(4.0), [0.02, 0, 0]), np.repeat(UP, 4, axis=0)),
        (np.zeros((3, 3)), np.vstack([UP, UP, -UP])),
    ],
    ids=["single", "duplicate", "collinear", "contradictory"],
)
def test_degenerate_contacts_give_a_surface_through_them(kernel, p, n):
    sheet = ContactSurface.of(p, n, kernel=kernel).follow()
    assert len(sheet.vertices) > 4
    distance = np.linalg.norm(sheet.vertices[None] - p[:, None], axis=2).min(axis=1)
    assert distance.max() < 0.004
    assert sheet.normals[:, 2].min() > 0.9


def test_contacts_that_cancel_each_other_leave_no_surface():
    sheet = ContactSurface.of(np.zeros((2, 3)), np.vstack([UP, -UP])).follow()
    assert len(sheet.vertices) == len(sheet.faces) == 0


@pytest.mark.parametrize(
    ("p", "n", "message"),
    [
        (np.array([[np.nan, 0, 0]]), UP, "not finite"),
        (np.zeros((1, 3)), 2 * UP, "unit length"),
        (np.zeros((2, 3)), UP, "2 contacts with 1 normals"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "no observation"),
    ],
)
def test_unusable_contacts_are_refused(p, n, message):
    with pytest.raises(BadInput, match=message):
        ContactSurface.of(p, n, noise=ContactNoise())
