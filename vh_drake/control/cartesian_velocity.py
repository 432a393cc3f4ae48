"""Cartesian velocity control: from the hand's velocity to the joints', by the pseudo-inverse."""

import numpy as np

from vh_drake.control import kernels
from vh_drake.errors import BadInput
from vh_drake.types import Array

SINGULAR_THRESHOLD = 0.05
LIMIT_HORIZON_S = 0.05


def cartesian_velocity_to_joints(
    spatial_velocity: Array,
    jacobian: Array,
    q: Array,
    *,
    lower: Array,
    upper: Array,
    velocity_limits: Array,
    singular_threshold: float = SINGULAR_THRESHOLD,
    limit_horizon_s: float = LIMIT_HORIZON_S,
) -> Array:
    r"""Joint velocities (n,) [rad/s] that give the hand a spatial velocity [w; v] (6,).

    .. math:: \dot\theta = J^+ \dot x
        = \sum_i v_i \frac{s_i}{s_i^2 + \lambda_i^2} u_i^\top \dot x,
        \quad \lambda_i^2 = \max(0, s_0^2 - s_i^2)

    The singular values s of J are damped only below the threshold s_0
    (Maciejewski and Klein 1988), which keeps joints slow at singular postures and the
    inverse exact elsewhere. A joint that would pass a position limit within the horizon
    gets the velocity that takes it there in that time, and the others do the rest of its work
    (Flacco et al. 2012). So joints slow down before their limits. Where a joint would
    exceed its velocity limit the whole vector is scaled, so that the hand keeps its
    direction and moves more slowly.

    Args:
        spatial_velocity: of the hand in W (6,) [rad/s, m/s].
        jacobian: of the hand in W (6, n).
        q: joint positions (n,) [rad].
        lower: position limits (n,) [rad].
        upper: position limits (n,) [rad].
        velocity_limits: (n,) [rad/s].
        singular_threshold: s_0, in the Jacobian's mixed units; 0 damps nothing.
        limit_horizon_s: how far ahead the position limits are seen [s].

    Raises:
        BadInput: the arrays' shapes don't fit, or a number is not finite.
    """
    velocity = np.ascontiguousarray(spatial_velocity, dtype=float)
    J = np.ascontiguousarray(jacobian, dtype=float)
    q = np.ascontiguousarray(q, dtype=float)
    _check(velocity, J, q)
    limits = np.array((lower, upper, velocity_limits), dtype=float)
    joint_velocity: Array = kernels.joint_velocity(
        J, velocity, q, limits, singular_threshold, limit_horizon_s
    )
    return joint_velocity


def _check(velocity: Array, J: Array, q: Array) -> None:
    if velocity.shape != (6,) or J.shape != (6, len(q)):
        raise BadInput(
            f"spatial velocity {velocity.shape}, Jacobian {J.shape} and joint positions "
            f"{q.shape} do not fit; pass (6,), (6, n) and (n,)"
        )
    if not (kernels.finite(velocity) and kernels.finite(J) and kernels.finite(q)):
        raise BadInput(
            "spatial velocity, Jacobian or joint positions are not finite; "
            "check the poses that they came from"
        )
