import numpy as np
import pytest

from vh_drake.gpis.growing_factor import GrowingFactor


def covariance(rows, seed=0):
    a = np.random.default_rng(seed).normal(size=(rows, rows + 3))
    return a @ a.T + np.eye(rows)


def grown(K, sizes):
    """The factor of K, its rows appended in blocks."""
    factor = GrowingFactor.of(np.linalg.cholesky(K[: sizes[0], : sizes[0]]))
    for size in sizes[1:]:
        a, b = factor.rows, factor.rows + size
        factor = factor.extended(K[a:b, :a], K[a:b, a:b])
    return factor


def test_rows_appended_in_blocks_give_the_cholesky_factor():
    K = covariance(40)
    factor = grown(K, [4, 1, 4, 16, 15])
    np.testing.assert_allclose(np.tril(factor.lower), np.linalg.cholesky(K), atol=1e-10)


def test_solution_is_that_of_the_symmetric_system():
    K, y = covariance(30), np.arange(30.0)
    np.testing.assert_allclose(grown(K, [10, 20]).solve(y), np.linalg.solve(K, y), rtol=1e-9)


def test_a_branch_leaves_the_other_successor_as_it_is():
    K, other = covariance(12), covariance(12, seed=1)
    trunk = grown(K, [4, 4])
    first = trunk.extended(K[8:, :8], K[8:, 8:])
    before = np.tril(first.lower).copy()
    second = trunk.extended(other[8:, :8], other[8:, 8:] + 50 * np.eye(4))
    np.testing.assert_array_equal(np.tril(first.lower), before)
    assert not np.allclose(np.tril(second.lower), before)
    np.testing.assert_allclose(np.tril(trunk.lower), before[:8, :8])


def test_a_matrix_that_is_not_positive_definite_is_refused_and_harms_nothing():
    K = covariance(8)
    factor = grown(K, [4])
    with pytest.raises(np.linalg.LinAlgError):
        factor.extended(K[:2, :4], K[:2, :2])  # the same rows again: singular
    np.testing.assert_allclose(
        np.tril(factor.extended(K[4:, :4], K[4:, 4:]).lower), np.linalg.cholesky(K), atol=1e-10
    )
