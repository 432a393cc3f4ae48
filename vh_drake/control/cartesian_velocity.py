"""Cartesian velocity control: from the hand's velocity to the joints', by the pseudo-inverse."""

import numpy as np

from vh_drake.control import kernels
from vh_drake.errors import BadInput
from vh_drake.types import Array

SINGULAR_THRESHOLD = 0.05


def cartesian_velocity_to_joints(
    spatial_velocity: Array,
    jacobian: Array,
    *,
    velocity_limits: Array,
    singular_threshold: float = SINGULAR_THRESHOLD,
) -> Array:
    r"""Joint velocities (n,) [rad/s] that give the hand a spatial velocity [w; v] (6,).

    .. math:: \dot\theta = J^+ \dot x = \sum_i v_i \frac{s_i}{s_i^2 + \lambda_i^2} u_i^\top \dot x,
        \quad \lambda_i^2 = \max(0, s_0^2 - s_i^2)

    The singular values s of J are damped only where they are below the threshold s_0
    (Maciejewski and Klein 1988), which keeps joints slow at singular postures and the
    inverse exact elsewhere. Where a joint would exceed its limit the whole
    vector is scaled, so that the hand keeps its direction and moves more slowly.

    Raises:
        BadInput: the arrays' shapes don't fit, or a number is not finite.
    """
    velocity = np.ascontiguousarray(spatial_velocity, dtype=float)
    J = np.ascontiguousarray(jacobian, dtype=float)
    if velocity.shape != (6,) or J.shape != (6, len(velocity_limits)):
        raise BadInput(
            f"spatial velocity {velocity.shape}, Jacobian {J.shape} and {len(velocity_limits)} "
            "velocity limits do not fit; pass (6,), (6, n) and (n,)"
        )
    if not (np.isfinite(velocity).all() and np.isfinite(J).all()):
        raise BadInput("spatial velocity or Jacobian is not finite; check the pose it came from")
    joint_velocity = kernels.damped_inverse_product(J, velocity, singular_threshold)
    scaled: Array = kernels.scale_to_limits(joint_velocity, np.asarray(velocity_limits, float))
    return scaled
