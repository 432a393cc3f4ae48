r"""Whether probabilities mean what they say, and making them.

A logit x becomes the probability :math:`1 / (1 + e^{-(a x + b)})` (Platt 2000), with a and b by
maximum likelihood on objects that the network was not trained on.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import expit
from scipy.stats import rankdata

from vh_drake.geometry.meshes import Mask
from vh_drake.types import Array

BINS = 15
_NEWTON_STEPS = 50
_RIDGE = 1e-6  # keeps the fit finite where the classes are separable


@dataclass(frozen=True)
class Calibration:
    """Slope and offset of logits."""

    slope: float = 1.0
    offset: float = 0.0

    def probability(self, logits: Array) -> Array:
        """Calibrated probabilities (n,)."""
        probability: Array = expit(self.slope * logits + self.offset)
        return probability


@dataclass(frozen=True, eq=False)
class Reliability:
    """A reliability diagram of k bins; empty bins are left out."""

    predicted: Array  # (k,) mean probability
    observed: Array  # (k,) share of successes
    count: Array  # (k,)

    @property
    def error(self) -> float:
        """Expected calibration error: the gap, weighted by the bins' counts."""
        gaps = np.abs(self.predicted - self.observed)
        return float((gaps * self.count).sum() / max(self.count.sum(), 1))


def fit_calibration(logits: Array, success: Array | Mask) -> Calibration:
    """Slope and offset of largest likelihood, by Newton's method.

    Args:
        logits: (n,).
        success: (n,) 0, 1, or a probability in between.
    """
    A = np.column_stack([logits, np.ones(len(logits))])
    w, step = np.zeros(2), np.ones(2)
    for _ in range(_NEWTON_STEPS):
        p = expit(A @ w)
        gradient = A.T @ (p - success) + _RIDGE * w
        hessian = (A * (p * (1 - p))[:, None]).T @ A + _RIDGE * np.eye(2)
        step = np.linalg.solve(hessian, gradient)
        while _cost(A, w - step, success) > _cost(A, w, success) + 1e-12:
            step /= 2  # Far from the optimum a whole step may lead away.
        w = w - step
        if np.abs(step).max() < 1e-10:
            break
    return Calibration(float(w[0]), float(w[1]))


def _cost(A: Array, w: Array, success: Array | Mask) -> float:
    """Negative log-likelihood, with the ridge."""
    logits = A @ w
    return float(np.sum(np.logaddexp(0, logits) - success * logits) + _RIDGE * (w @ w) / 2)


def reliability(probability: Array, success: Array | Mask, bins: int = BINS) -> Reliability:
    """Predicted against observed success in bins of equal width."""
    predicted, observed, count = reliability_sums(probability, success, bins)
    kept = count > 0
    return Reliability(predicted[kept] / count[kept], observed[kept] / count[kept], count[kept])


def reliability_sums(probability: Array, success: Array | Mask, bins: int = BINS) -> Array:
    """Sums (3, bins) of predictions, of successes and of candidates in bins of equal width."""
    index = np.minimum((probability * bins).astype(int), bins - 1)
    weights = (probability, np.asarray(success, float), np.ones(len(index)))
    return np.stack([np.bincount(index, weights=values, minlength=bins) for values in weights])


def auc(scores: Array, positive: Mask) -> float:
    """Area under the ROC curve (ties count half); 0.5 where a class is missing."""
    ones, zeros = int(positive.sum()), int((~positive).sum())
    if ones == 0 or zeros == 0:
        return 0.5
    ranks = rankdata(scores)
    return float((ranks[positive].sum() - ones * (ones + 1) / 2) / (ones * zeros))
