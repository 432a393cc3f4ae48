"""Cartesian position control: from where the hand is and should be to a bounded velocity."""

import numpy as np

from vh_drake.control import kernels
from vh_drake.errors import BadInput
from vh_drake.types import Array

GAIN_PER_S = 5.0
MAX_ANGULAR_RAD_S = 1.5
MAX_LINEAR_M_S = 0.4


def cartesian_position_velocity(
    X_WH_target: Array,
    X_WH: Array,
    *,
    V_WH_target: Array | None = None,
    gain_per_s: float = GAIN_PER_S,
    max_angular_rad_s: float = MAX_ANGULAR_RAD_S,
    max_linear_m_s: float = MAX_LINEAR_M_S,
) -> Array:
    r"""Spatial velocity [w; v] (6,) of H in W that moves the hand to its target.

    .. math:: V = \lambda e, \quad
        e = \begin{bmatrix} \log(R_t R^\top) \\ p_t - p \end{bmatrix} + V_t / K, \quad
        \lambda = \min(K, \omega_{max} / |e_R|, v_{max} / |e_p|)

    One factor scales both parts, so that turning and moving end together and the path is
    straight; near the target it is the gain K, so that the hand comes to rest smoothly. Told how
    the target moves, V_t, the hand keeps up with it; else it lags by V_t / K.

    Args:
        X_WH_target: homogeneous pose (4, 4) to reach.
        X_WH: homogeneous pose (4, 4) now.
        V_WH_target: spatial velocity V_t (6,) of the target; None: it stands still.
        gain_per_s: K [1/s].
        max_angular_rad_s: bound of the angular part.
        max_linear_m_s: bound of the linear part.

    Raises:
        BadInput: a pose is no (4, 4) array of finite numbers.
    """
    velocity: Array = kernels.pursuit(
        _checked(X_WH_target),
        _checked(X_WH),
        np.zeros(6) if V_WH_target is None else np.ascontiguousarray(V_WH_target, dtype=float),
        gain_per_s,
        max_angular_rad_s,
        max_linear_m_s,
    )
    return velocity


def pose_error(X_WH_target: Array, X_WH: Array) -> Array:
    """Rotation vector [rad] and translation [m] (6,) from the pose to the target, in W."""
    error: Array = kernels.pose_error(_checked(X_WH_target), _checked(X_WH))
    return error


def _checked(X: Array) -> Array:
    X = np.ascontiguousarray(X, dtype=float)
    if X.shape != (4, 4) or not kernels.finite(X):
        raise BadInput(f"a pose is a finite array of shape (4, 4), not {X.tolist()}")
    return X
