"""Colours that stand for numbers."""

import numpy as np
from matplotlib import colormaps

from vh_drake.types import Array

# The largest uncertainty that colours tell apart: beyond it the surface is a guess [m].
TOP_STD_M = 0.004


_RED_TO_GREEN = ((0.8, 0.0, 0.05), (0.9, 0.6, 0.0), (0.0, 0.55, 0.1))


def variance_colors(variance: Array, *, top_std: float = TOP_STD_M) -> Array:
    """Colours (n, 3) of variances (n,): dark violet is certain, yellow is a guess.

    The standard deviation is what is shown, on a scale that stays the same, so that two
    estimates can be compared.

    Args:
        variance: of the potential.
        top_std: standard deviation from which on all is yellow.
    """
    share = np.sqrt(np.maximum(variance, 0.0)) / top_std
    rgb: Array = np.asarray(colormaps["viridis"](np.clip(share, 0.0, 1.0)))[..., :3].astype(float)
    return rgb


def score_colors(score: Array) -> Array:
    """Colours (n, 3) of scores (n,) in 0..1: red is bad, green is good; NaN counts as 0."""
    share = np.clip(np.nan_to_num(score), 0.0, 1.0)
    channels = np.transpose(_RED_TO_GREEN)
    return np.column_stack([np.interp(share, [0.0, 0.5, 1.0], channel) for channel in channels])
