"""The posterior beside those of GPyTorch and scikit-learn, in float64."""

import numpy as np
import pytest

from vh_drake.gpis.kernels import SquaredExponential
from vh_drake.gpis.observations import Observations, value_observations
from vh_drake.gpis.posterior import fit

LENGTH_M, SIGNAL_M = 0.06, 0.03
KERNEL = SquaredExponential(LENGTH_M, SIGNAL_M)
JITTER = 1e-9 * SIGNAL_M**2  # what the posterior adds to every variance, in m²


def contacts(count, seed=0):
    """Contacts on a bumpy ball, each with noise of its own."""
    rng = np.random.default_rng(seed)
    n = rng.normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    p = (0.05 + 0.005 * np.sin(3 * n[:, :1])) * n
    return Observations(
        p,
        rng.normal(0, 1e-3, count),
        rng.uniform(1e-3, 3e-3, count) ** 2,
        n,
        rng.uniform(0.05, 0.2, count) ** 2,
    )


def queries(count, seed=1):
    return np.random.default_rng(seed).uniform(-0.08, 0.08, (count, 3))


def gpytorch_kernel(x, y):
    """Covariance of values and gradients at points x with those at points y, interleaved.

    In decimetres: in metres the condition of the matrix costs two digits.
    """
    torch, gpytorch = pytest.importorskip("torch"), pytest.importorskip("gpytorch")
    kernel = gpytorch.kernels.ScaleKernel(gpytorch.kernels.RBFKernelGrad()).double()
    kernel.outputscale = torch.tensor((10 * SIGNAL_M) ** 2, dtype=torch.float64)  # a float is
    kernel.base_kernel.lengthscale = torch.tensor(10 * LENGTH_M, dtype=torch.float64)  # rounded
    with torch.no_grad():
        return kernel(torch.from_numpy(10 * x), torch.from_numpy(10 * y)).to_dense().numpy()


def test_mean_gradient_and_variance_equal_those_from_the_kernel_of_gpytorch():
    seen, x = contacts(40), queries(60)
    noise = np.column_stack([100 * seen.value_variance, *[seen.gradient_variance] * 3])
    K = gpytorch_kernel(seen.p, seen.p) + np.diag(noise.ravel() + 100 * JITTER)
    cross = gpytorch_kernel(x, seen.p)
    y = np.column_stack([10 * seen.value, seen.gradient]).ravel()
    expected = (cross @ np.linalg.solve(K, y)).reshape(-1, 4)
    posterior = fit(KERNEL, seen)
    scale = np.abs(expected[:, 0]).max()
    assert np.abs(10 * posterior.mean(x) - expected[:, 0]).max() < 1e-8 * scale
    assert np.abs(posterior.gradient(x) - expected[:, 1:]).max() < 1e-8
    explained = np.einsum("ij,ji->i", cross[::4], np.linalg.solve(K, cross[::4].T))
    assert (
        np.abs(posterior.variance(x) - (SIGNAL_M**2 - explained / 100)).max() < 1e-8 * SIGNAL_M**2
    )


def test_values_alone_give_the_regression_of_scikit_learn():
    sklearn = pytest.importorskip("sklearn.gaussian_process")
    kernels = pytest.importorskip("sklearn.gaussian_process.kernels")
    p, x = queries(40, seed=2), queries(60, seed=3)
    value = 0.02 * np.cos(40 * p[:, 0])
    std = 1e-3
    peer = sklearn.GaussianProcessRegressor(
        kernels.ConstantKernel(SIGNAL_M**2) * kernels.RBF(LENGTH_M),
        alpha=std**2 + JITTER,
        optimizer=None,
    ).fit(p, value)
    mean, deviation = peer.predict(x, return_std=True)
    posterior = fit(KERNEL, value_observations(p, value, value_std_m=std))
    assert np.abs(posterior.mean(x) - mean).max() < 1e-8 * np.abs(mean).max()
    assert np.abs(posterior.variance(x) - deviation**2).max() < 1e-8 * SIGNAL_M**2
