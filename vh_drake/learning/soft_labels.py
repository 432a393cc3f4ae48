"""How probable success is where a label comes from few trials.

A label from few trials is not sure on which side of the threshold its grasp lies; as a target
this costs nothing, and the network learns the expected success. What all labels of a data set
say together is the prior of each: most grasps nearly always close, or nearly never do.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import betainc
from scipy.stats import betabinom

from vh_drake.learning.labels import SUCCESS_RATE
from vh_drake.types import Array, IntArray

_FARTHEST = 5.0  # of the logarithms of a prior's parameters, which keeps them finite


@dataclass(frozen=True)
class RatePrior:
    """Beta distribution of the true rates of grasps; uniform unless told."""

    closing: float = 1.0
    failing: float = 1.0

    def success_probability(self, rate: Array, samples: IntArray) -> Array:
        """How probable (n,) a true rate over 0.8 is.

        Args:
            rate: (n,) share of trials with force closure.
            samples: (n,) trials.
        """
        closed = np.rint(rate * samples)
        below: Array = betainc(closed + self.closing, samples - closed + self.failing, SUCCESS_RATE)
        return 1 - below


def fit_prior(rate: Array, samples: IntArray) -> RatePrior:
    """The prior under which many labels are most likely (beta-binomial, empirical Bayes).

    Args:
        rate: (n,) share of trials with force closure.
        samples: (n,) trials.
    """
    trials = np.column_stack([np.rint(rate * samples), samples]).astype(np.int64)
    (closed, count), times = _distinct(trials)

    def cost(logs: Array) -> float:
        kept = np.exp(np.clip(logs, -_FARTHEST, _FARTHEST))
        return -float(np.average(betabinom.logpmf(closed, count, *kept), weights=times))

    best = minimize(cost, np.zeros(2), method="Nelder-Mead", options={"xatol": 1e-4})
    closing, failing = np.exp(np.clip(best.x, -_FARTHEST, _FARTHEST))
    return RatePrior(float(closing), float(failing))


def _distinct(trials: IntArray) -> tuple[IntArray, IntArray]:
    rows, times = np.unique(trials, axis=0, return_counts=True)
    return rows.T, times
