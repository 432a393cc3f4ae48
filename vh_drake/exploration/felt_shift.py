r"""Where an object is that a badly calibrated camera saw: what a touch tells of it.

The error of the camera's pose that is left moves all points alike along the table, by a shift
:math:`x`. Its scale is known from the few errors that the table told, so that its prior is
Student's distribution with as many degrees of freedom, :math:`\nu`, and the scale
:math:`\Sigma`. At a touch the hand's surface meets the object's, and nowhere before on its way
did it enter it. With :math:`d` the estimate's signed distance and :math:`c_{ki}, r_i` the hand's
spheres on its way,

.. math:: g_k(x) = \min_i d(c_{ki} - x) - r_i, \qquad
    -2 \log p(x) = (\nu + 2) \log\left(1 + \frac{x^T \Sigma^{-1} x}{\nu}\right)
    + \frac{g_K^2 + \sum_{k<K} \min(g_k, 0)^2}{\sigma^2}.

The posterior is summed up on a grid.
"""

import numpy as np

from vh_drake.geometry.signed_distance import interpolate
from vh_drake.types import Array, ScalarGrid

_ERROR_M = 0.003  # of the estimate's surface
_FREEDOM = 3  # two tilts and a rise
_CELLS = 61  # of the grid along each axis
_DEVIATIONS, _MOST_M = 5.0, 0.06  # that it spans to each side, of the larger one


def felt_shift(
    distance: ScalarGrid, centers: Array, radii: Array, covariance: Array
) -> tuple[Array, Array]:
    """Mean and covariance of the shift after a touch.

    Args:
        distance: signed distance of the estimate [m].
        centers: (k, s, 3) of the hand's spheres on its way, the last at the touch [m].
        radii: (s,) of the spheres [m].
        covariance: (3, 3) of the shift before, of rank 2 [m²].

    Returns:
        The mean (3,) [m] and the covariance (3, 3) [m²].
    """
    shifts, cost = _prior(covariance)
    gaps = np.array([_gaps(distance, way, radii, shifts) for way in centers])
    gaps[:-1] = np.minimum(gaps[:-1], 0.0)
    cost = cost + (gaps**2).sum(axis=0) / _ERROR_M**2
    weight = np.exp(-0.5 * (cost - cost.min()))
    weight /= weight.sum()
    mean: Array = weight @ shifts
    left = shifts - mean
    after: Array = (weight[:, None] * left).T @ left
    return mean, after


def _prior(covariance: Array) -> tuple[Array, Array]:
    """Shifts (m, 3) on a grid along the covariance's axes, and how unlikely (m,) they are."""
    variances, axes = np.linalg.eigh(covariance)
    reach = min(_DEVIATIONS * np.sqrt(variances[2]), _MOST_M)
    steps = np.linspace(-reach, reach, _CELLS)
    along = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    square = (along**2 / np.maximum(variances[1:], 1e-12)).sum(axis=1)
    cost: Array = (_FREEDOM + 2) * np.log1p(square / _FREEDOM)
    return along @ axes[:, 1:].T, cost


def _gaps(distance: ScalarGrid, centers: Array, radii: Array, shifts: Array) -> Array:
    """Least distance (m,) between the spheres (s, 3) and the object where each shift puts it."""
    points = centers[None] - shifts[:, None]
    d = interpolate(distance, points.reshape(-1, 3))[0].reshape(points.shape[:2])
    gaps: Array = (d - radii).min(axis=1)
    return gaps
