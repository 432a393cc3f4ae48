import numpy as np
import pytest

from vh_drake.errors import BadInput, IllConditionedKernel
from vh_drake.gpis.kernels import SquaredExponential, ThinPlate
from vh_drake.gpis.observations import surface_observations, value_observations
from vh_drake.gpis.posterior import SCALE_M, fit

KERNELS = [SquaredExponential(0.05, 0.05), ThinPlate()]


def sphere(count, seed=0, radius=0.05):
    n = np.random.default_rng(seed).normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return radius * n, n


def sphere_observations(count, seed=0):
    return surface_observations(*sphere(count, seed), value_std_m=1e-3, gradient_std=0.05)


def brute_force(kernel, observations, x):
    """Rasmussen & Williams eq. 2.25, 2.26 by a plain inverse, derivatives by differences."""

    def k(a, b):
        d, length = np.linalg.norm(a - b) / SCALE_M, kernel.length_m / SCALE_M
        signal2 = (kernel.signal_std_m / SCALE_M) ** 2
        if isinstance(kernel, SquaredExponential):
            return signal2 * np.exp(-0.5 * d**2 / length**2)
        return signal2 * (2 * d**3 - 3 * length * d**2 + length**3) / length**3

    values = observations.value / SCALE_M
    noise = observations.value_variance / SCALE_M**2 + 1e-9 * k(x[0], x[0])
    K = np.array([[k(a, b) for b in observations.p] for a in observations.p])
    cross = np.array([[k(a, b) for b in observations.p] for a in x])
    inverse = np.linalg.inv(K + np.diag(noise))
    variance = k(x[0], x[0]) - np.einsum("ij,jk,ik->i", cross, inverse, cross)
    return SCALE_M * cross @ inverse @ values, SCALE_M**2 * variance


@pytest.mark.parametrize("kernel", KERNELS)
def test_values_alone_give_the_textbook_mean_and_variance(kernel):
    rng = np.random.default_rng(4)
    seen = value_observations(
        rng.uniform(-0.1, 0.1, (8, 3)), rng.normal(0, 0.02, 8), value_std_m=0.002
    )
    x = rng.uniform(-0.1, 0.1, (6, 3))
    posterior = fit(kernel, seen)
    mean, variance = brute_force(kernel, seen, x)
    np.testing.assert_allclose(posterior.mean(x), mean, atol=1e-9)
    np.testing.assert_allclose(posterior.variance(x), variance, atol=1e-9)


@pytest.mark.parametrize("kernel", KERNELS)
def test_gradient_matches_finite_differences_of_the_mean(kernel):
    posterior = fit(kernel, sphere_observations(20))
    x, step = np.random.default_rng(5).uniform(-0.06, 0.06, (9, 3)), 1e-6
    differences = [
        (posterior.mean(x + step * e) - posterior.mean(x - step * e)) / (2 * step)
        for e in np.eye(3)
    ]
    np.testing.assert_allclose(posterior.gradient(x), np.column_stack(differences), atol=1e-6)


@pytest.mark.parametrize("kernel", KERNELS)
def test_observed_values_and_normals_are_reproduced(kernel):
    seen = surface_observations(*sphere(15), value_std_m=1e-5, gradient_std=1e-3)
    posterior = fit(kernel, seen)
    assert np.abs(posterior.mean(seen.p)).max() < 1e-4
    assert np.abs(posterior.gradient(seen.p) - seen.gradient).max() < 0.02


def test_thin_plate_finds_a_sphere_between_its_contacts():
    posterior = fit(ThinPlate(), sphere_observations(40))
    _, n = sphere(200, seed=9)
    assert np.all(posterior.mean(0.042 * n) < 0)
    assert np.all(posterior.mean(0.058 * n) > 0)


@pytest.mark.parametrize("kernel", KERNELS)
def test_appending_equals_fitting_anew(kernel):
    first, second = sphere_observations(12), sphere_observations(5, seed=1)
    outside = value_observations(np.array([[0.1, 0, 0]]), np.array([0.05]), value_std_m=0.01)
    updated = fit(kernel, first).append(outside).append(second)
    anew = fit(kernel, first.joined(outside).joined(second))
    x = np.random.default_rng(6).uniform(-0.08, 0.08, (30, 3))
    np.testing.assert_allclose(updated.mean(x), anew.mean(x), atol=1e-9)
    np.testing.assert_allclose(updated.variance(x), anew.variance(x), atol=1e-9)


@pytest.mark.parametrize("kernel", KERNELS)
def test_variance_never_rises_when_a_contact_is_added(kernel):
    x = np.random.default_rng(7).uniform(-0.08, 0.08, (100, 3))
    posterior = fit(kernel, sphere_observations(6))
    for seed in range(1, 5):
        more = posterior.append(sphere_observations(1, seed))
        assert np.all(more.variance(x) <= posterior.variance(x) + 1e-12)
        posterior = more


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_rigid_motion_of_the_data_moves_the_potential(kernel):
    rng = np.random.default_rng(8)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shift = np.array([0.4, -0.2, 0.7])
    p, n = sphere(10)
    x = rng.uniform(-0.08, 0.08, (20, 3))
    still = fit(kernel, surface_observations(p, n, value_std_m=1e-3, gradient_std=0.1))
    moved = fit(
        kernel,
        surface_observations(
            p @ rotation.T + shift, n @ rotation.T, value_std_m=1e-3, gradient_std=0.1
        ),
    )
    np.testing.assert_allclose(moved.mean(x @ rotation.T + shift), still.mean(x), atol=1e-9)


@pytest.mark.parametrize("kernel", KERNELS)
def test_potential_on_a_grid_equals_the_potential_at_its_nodes(kernel):
    posterior = fit(kernel, sphere_observations(9))
    x, y, z = np.linspace(-0.1, 0.1, 5), np.linspace(-0.05, 0.1, 6), np.linspace(-0.1, 0.0, 4)
    nodes = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)
    np.testing.assert_allclose(
        posterior.mean_on_grid(x, y, z).ravel(), posterior.mean(nodes.reshape(-1, 3)), atol=1e-10
    )


def test_duplicate_and_contradictory_contacts_give_a_finite_potential():
    p = np.repeat(np.array([[0.0, 0.0, 0.05]]), 3, axis=0)
    n = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    posterior = fit(ThinPlate(), surface_observations(p, n, value_std_m=1e-3, gradient_std=0.1))
    np.testing.assert_allclose(posterior.gradient(p[:1]), [[0.0, 0.0, 1.0 / 3.0]], atol=0.02)


def test_a_single_contact_gives_a_plane_near_it():
    one = surface_observations(
        np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), value_std_m=1e-4, gradient_std=1e-2
    )
    mean = fit(ThinPlate(), one).mean(np.array([[0.01, 0, 0], [0, 0, 0.01], [0, 0, -0.01]]))
    np.testing.assert_allclose(mean, [0.0, 0.01, -0.01], atol=1e-3)


def test_thin_plate_narrower_than_the_data_says_what_helps():
    p, n = sphere(30, radius=0.5)
    seen = surface_observations(p, n, value_std_m=1e-6, gradient_std=1e-6)
    with pytest.raises(IllConditionedKernel, match="widen a thin plate's radius"):
        fit(ThinPlate(length_m=0.3), seen)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_refused(bad):
    seen = value_observations(np.array([[bad, 0, 0]]), np.zeros(1), value_std_m=0.01)
    with pytest.raises(BadInput, match="NaN or infinite"):
        fit(ThinPlate(), seen)


def test_fitting_nothing_is_refused():
    with pytest.raises(BadInput, match="no observation"):
        fit(ThinPlate(), value_observations(np.zeros((0, 3)), np.zeros(0), value_std_m=0.01))
