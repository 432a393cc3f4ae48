"""The same Gaussian processes in GPyTorch and scikit-learn, each used as fast as it goes.

Lengths are scaled as in `vh_drake.gpis.posterior`, so that all solve the same system.
"""

import importlib
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from typing import Any

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.gpis.kernels import SquaredExponential
from vh_drake.gpis.observations import Observations
from vh_drake.gpis.posterior import JITTER, SCALE_M
from vh_drake.types import Array

_MEAN_CHUNK = 500  # points a product; more or fewer is slower
_PREDICT_CHUNK = 100


def require(name: str) -> Any:
    """A package of the extra `bench`.

    Raises:
        BadInput: it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BadInput(f"{name} is missing; pip install 'vh_drake[bench]'") from error


class GPyTorchSurface:
    """An exact process on values and gradients, `RBFKernelGrad`, float64, Cholesky throughout."""

    def __init__(self, kernel: SquaredExponential, observations: Observations) -> None:
        self._torch, gpytorch = require("torch"), require("gpytorch")
        self._gpytorch = gpytorch
        signal2 = (kernel.signal_std_m / SCALE_M) ** 2
        likelihood = gpytorch.likelihoods.MultitaskGaussianLikelihood(
            num_tasks=4,
            has_global_noise=False,
            noise_constraint=gpytorch.constraints.GreaterThan(0.0),
        ).double()
        value = observations.value_variance[0] / SCALE_M**2
        noise = np.array([value, *[observations.gradient_variance[0]] * 3]) + JITTER * signal2
        likelihood.task_noises = self._torch.from_numpy(noise)
        self._x = self._torch.from_numpy(observations.p / SCALE_M)
        y = np.column_stack([observations.value / SCALE_M, observations.gradient])
        self._model = _exact_gp(gpytorch)(self._x, self._torch.from_numpy(y), likelihood).double()
        covariance = self._model.covar_module  # plain numbers would be rounded to float32
        covariance.outputscale = self._torch.tensor(signal2, dtype=self._torch.float64)
        covariance.base_kernel.lengthscale = self._torch.tensor(
            kernel.length_m / SCALE_M, dtype=self._torch.float64
        )
        self._model.eval()
        with self._settings():
            self._model(self._x[:1])  # factorises and solves
        self._weights = self._model.prediction_strategy.mean_cache

    def mean(self, p: Array) -> Array:
        """Potential (m,) at points (m, 3) [m], by its kernel and cached weights alone."""
        return SCALE_M * self._by_chunks(
            p, _MEAN_CHUNK, lambda x: (self._covariance(x) @ self._weights)[::4]
        )

    def predicted_mean(self, p: Array) -> Array:
        """Potential (m,) at points (m, 3) [m], as its users ask for it: `model(x).mean`."""
        return SCALE_M * self._by_chunks(
            p, _PREDICT_CHUNK, lambda x: self._model(x).mean[:, 0], skip_variance=True
        )

    def variance(self, p: Array) -> Array:
        """Variance of the potential (m,) at points (m, 3) [m²]."""
        return SCALE_M**2 * self._by_chunks(
            p, _PREDICT_CHUNK, lambda x: self._model(x).variance[:, 0]
        )

    def _covariance(self, x: Any) -> Any:
        return self._model.covar_module(x, self._x).to_dense()

    def _by_chunks(
        self, p: Array, size: int, function: Callable[[Any], Any], *, skip_variance: bool = False
    ) -> Array:
        x = self._torch.from_numpy(p / SCALE_M)
        with self._settings(skip_variance=skip_variance):
            parts = [function(x[i : i + size]).numpy() for i in range(0, len(x), size)]
        return np.concatenate(parts)

    def _settings(self, *, skip_variance: bool = False) -> AbstractContextManager[Any]:
        stack, settings = ExitStack(), self._gpytorch.settings
        stack.enter_context(self._torch.no_grad())
        stack.enter_context(settings.fast_computations(False, False, False))
        stack.enter_context(settings.skip_posterior_variances(skip_variance))
        return stack


def _exact_gp(gpytorch: Any) -> Any:
    class ValuesAndGradients(gpytorch.models.ExactGP):
        def __init__(self, x: Any, y: Any, likelihood: Any) -> None:
            super().__init__(x, y, likelihood)
            self.mean_module = gpytorch.means.ConstantMeanGrad()
            self.covar_module = gpytorch.kernels.ScaleKernel(gpytorch.kernels.RBFKernelGrad())

        def forward(self, x: Any) -> Any:
            return gpytorch.distributions.MultitaskMultivariateNormal(
                self.mean_module(x), self.covar_module(x)
            )

    return ValuesAndGradients


class ScikitSurface:
    """A regression on values alone, as scikit-learn knows no gradients."""

    def __init__(self, kernel: SquaredExponential, observations: Observations) -> None:
        process = require("sklearn.gaussian_process")
        signal2 = (kernel.signal_std_m / SCALE_M) ** 2
        covariance = process.kernels.ConstantKernel(signal2) * process.kernels.RBF(
            kernel.length_m / SCALE_M
        )
        self._model = process.GaussianProcessRegressor(
            covariance,
            alpha=observations.value_variance / SCALE_M**2 + JITTER * signal2,
            optimizer=None,
        ).fit(observations.p / SCALE_M, observations.value / SCALE_M)

    def mean(self, p: Array) -> Array:
        """Potential (m,) at points (m, 3) [m]."""
        mean: Array = SCALE_M * self._model.predict(p / SCALE_M)
        return mean

    def variance(self, p: Array) -> Array:
        """Variance of the potential (m,) at points (m, 3) [m²]."""
        _, deviation = self._model.predict(p / SCALE_M, return_std=True)
        variance: Array = (SCALE_M * deviation) ** 2
        return variance
