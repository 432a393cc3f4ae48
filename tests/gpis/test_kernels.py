import numpy as np
import pytest

from vh_drake.gpis.kernels import (
    SQUARED_EXPONENTIAL,
    THIN_PLATE,
    covariance_matrix,
    weighted_sum,
)

KERNELS = [(SQUARED_EXPONENTIAL, 0.7, 1.3), (THIN_PLATE, 4.0, 0.8)]


def closed_form(code, length, signal2, x, y):
    d = np.linalg.norm(x - y)
    if code == SQUARED_EXPONENTIAL:
        return signal2 * np.exp(-0.5 * d**2 / length**2)
    return signal2 * (2 * d**3 - 3 * length * d**2 + length**3) / length**3


def block(code, length, signal2, x, y):
    four = np.array([0, 4], dtype=np.int64)
    return covariance_matrix(code, length, signal2, x[None], four, y[None], four)


def central(function, x, step):
    """Gradient of a function of a point, by central differences."""
    return np.array([(function(x + e) - function(x - e)) / (2 * step) for e in step * np.eye(3)])


@pytest.mark.parametrize("kernel", KERNELS)
def test_every_block_matches_finite_differences(kernel):
    rng = np.random.default_rng(0)
    for _ in range(5):
        x, y = rng.uniform(-1, 1, (2, 3))
        K = block(*kernel, x, y)
        value = closed_form(*kernel, x, y)
        by_x = central(lambda a, y=y: closed_form(*kernel, a, y), x, 1e-5)
        by_y = central(lambda b, x=x: closed_form(*kernel, x, b), y, 1e-5)
        both = central(
            lambda a, y=y: central(lambda b: closed_form(*kernel, a, b), y, 1e-4), x, 1e-4
        )
        np.testing.assert_allclose(K[0, 0], value, atol=1e-12)
        np.testing.assert_allclose(K[1:, 0], by_x, atol=1e-8)
        np.testing.assert_allclose(K[0, 1:], by_y, atol=1e-8)
        np.testing.assert_allclose(K[1:, 1:], both, atol=1e-5)


@pytest.mark.parametrize("kernel", KERNELS)
def test_block_at_distance_zero_is_the_limit_of_near_points(kernel):
    x = np.array([0.3, -0.2, 0.5])
    near = x + 1e-7 * np.array([0.6, 0.0, 0.8])
    np.testing.assert_allclose(block(*kernel, x, x), block(*kernel, x, near), atol=1e-5)


@pytest.mark.parametrize("kernel", KERNELS)
def test_matrix_of_values_and_gradients_is_symmetric_and_positive_semidefinite(kernel):
    rng = np.random.default_rng(1)
    p = rng.uniform(-1, 1, (12, 3))
    starts = np.concatenate([[0], np.cumsum(rng.choice([1, 4], 12))]).astype(np.int64)
    K = covariance_matrix(*kernel, p, starts, p, starts)
    np.testing.assert_allclose(K, K.T, atol=1e-12)
    assert np.linalg.eigvalsh(K).min() > -1e-10


@pytest.mark.parametrize("kernel", KERNELS)
def test_covariance_depends_on_the_distance_only(kernel):
    rng = np.random.default_rng(2)
    x, y, shift = rng.uniform(-1, 1, (3, 3))
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    moved = block(*kernel, rotation @ x + shift, rotation @ y + shift)
    whole = np.eye(4)
    whole[1:, 1:] = rotation
    np.testing.assert_allclose(moved, whole @ block(*kernel, x, y) @ whole.T, atol=1e-12)


@pytest.mark.parametrize("kernel", KERNELS)
def test_weighted_sums_equal_products_with_the_covariance_matrix(kernel):
    rng = np.random.default_rng(3)
    x, p, weights = rng.uniform(-1, 1, (7, 3)), rng.uniform(-1, 1, (5, 3)), rng.normal(size=(5, 4))
    four = [4 * np.arange(n + 1, dtype=np.int64) for n in (7, 5)]
    rows = (covariance_matrix(*kernel, x, four[0], p, four[1]) @ weights.ravel()).reshape(7, 4)
    columns = np.ascontiguousarray(np.column_stack([p, weights]).T)
    np.testing.assert_allclose(weighted_sum(*kernel, x, columns), rows, atol=1e-11)
