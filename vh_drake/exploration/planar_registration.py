r"""How an object has moved on its table between two looks.

Of the new view's points :math:`p_i` and the old estimate's signed distance :math:`d`,

.. math:: \min_{x, y, \theta} \sum_i \rho\left(d(R_\theta^{-1} (p_i - c - t) + c)^2\right)

over turns about the table's normal and shifts along the table, from several first guesses;
:math:`\rho` is a soft L1 loss and :math:`c` the middle of the view. A turn costs a little,
since a thing that is round shows none.
"""

import dataclasses as dc

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from vh_drake.geometry.signed_distance import interpolate
from vh_drake.gpis.evidence import farthest_points
from vh_drake.types import Array, Immutable, Plane, ScalarGrid

_POINTS = 300
_FIRST_TURNS_DEG = (0, 15, -15, 40, -40, 90, -90, 180)
_SOFT_M = 0.003
_TURN_M = 0.0005  # what a turn by 1 rad costs: a thing that is round has not turned


@dc.dataclass(frozen=True, eq=False)
class Motion(Immutable):
    """Where an object went."""

    X_NewOld: Array = dc.field(default_factory=lambda: np.eye(4))  # (4, 4) on old points
    error_m: float = 0.0  # that three quarters of the new points keep to the moved estimate


def registered(distance: ScalarGrid, p_W: Array, table: Plane) -> Motion:
    """The motion along the table that fits an old estimate best to new points.

    Args:
        distance: signed distance of the old estimate [m].
        p_W: (n, 3) new points of the object, n > 0 [m].
        table: on which it moved.
    """
    points = p_W[farthest_points(p_W, min(_POINTS, len(p_W)))]
    middle = points.mean(axis=0)
    old_middle = distance.origin + 0.5 * distance.spacing * (np.array(distance.values.shape) - 1)
    shift = _along(table.normal) @ (middle - old_middle)
    fits = [
        least_squares(
            lambda x: _residuals(distance, points, x, middle, table.normal),
            np.array([*start, np.deg2rad(turn)]),
            loss="soft_l1",
            f_scale=_SOFT_M,
            x_scale=(0.01, 0.01, 0.1),
            max_nfev=30,
        )
        for turn in _FIRST_TURNS_DEG
        for start in ((np.zeros(2), shift) if turn == 0 else (shift,))
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    gaps = interpolate(distance, _back(points, best.x, middle, table.normal))[0]
    return Motion(_motion(best.x, middle, table.normal), float(np.quantile(np.abs(gaps), 0.75)))


def _residuals(
    distance: ScalarGrid, points: Array, x: Array, middle: Array, normal: Array
) -> Array:
    """Misfits of points (n,) and the cost of the turn."""
    gaps = interpolate(distance, _back(points, x, middle, normal))[0]
    return np.append(gaps, np.sqrt(len(points)) * _TURN_M * x[2])


def _along(normal: Array) -> Array:
    """Two unit vectors (2, 3) along a plane."""
    rows: Array = np.linalg.svd(normal[None])[2][1:]
    return rows


def _motion(x: Array, middle: Array, normal: Array) -> Array:
    """X (4, 4): a turn x[2] about the normal at the old middle, which comes to the new one."""
    X = np.eye(4)
    X[:3, :3] = Rotation.from_rotvec(x[2] * normal).as_matrix()
    shift = x[:2] @ _along(normal)
    X[:3, 3] = middle - X[:3, :3] @ (middle - shift)
    return X


def _back(points: Array, x: Array, middle: Array, normal: Array) -> Array:
    """New points (n, 3) where they were before the motion."""
    X = _motion(x, middle, normal)
    back: Array = (points - X[:3, 3]) @ X[:3, :3]
    return back
