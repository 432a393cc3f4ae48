"""Null-space control: the arm's spare joints keep it away from its joint limits."""

import numpy as np

from vh_drake.control import kernels
from vh_drake.control.cartesian_velocity import LIMIT_HORIZON_S, SINGULAR_THRESHOLD
from vh_drake.errors import BadInput
from vh_drake.types import Array

GAIN = 1.5  # p_N of equation 4.7; the thesis names 1 to 2
RANK_TOLERANCE = 1e-6


def null_space_basis(jacobian: Array) -> Array:
    r"""Orthonormal N (n, k) with J N = 0 (eq. 4.3 and 4.4), by singular values.

    k is n - 6 for an arm away from singular postures and more in them.
    """
    N: Array = kernels.null_space_basis(_contiguous(jacobian), RANK_TOLERANCE)
    return N


def limit_avoidance(q: Array, lower: Array, upper: Array) -> Array:
    r"""Velocities (n,) [rad/s] away from the joint limits (eq. 4.5).

    .. math:: \dot\theta^a_i = \cos(\pi (\theta_i - \theta^-_i) / (\theta^+_i - \theta^-_i))

    1 at the lower limit, 0 in the middle, -1 at the upper limit.
    """
    avoidance: Array = kernels.limit_avoidance(q, lower, upper)
    return avoidance


def null_space_velocity(
    jacobian: Array,
    q: Array,
    lower: Array,
    upper: Array,
    *,
    singular_threshold: float = SINGULAR_THRESHOLD,
) -> Array:
    r"""The part of the limit avoidance that leaves the hand still (n,) (eq. 4.6).

    .. math:: \dot\theta^N = \sum_j N_j \, (N_j \cdot \dot\theta^a) / |N_j|^2

    The sum holds for orthogonal columns N_j; they are orthonormal here. Near a singular posture
    the null space turns fast with the joints, and a hand that follows it trembles. So the
    velocity fades out by (s / s_0)² where the least singular value s of J is below s_0, and is
    zero in the posture itself.

    Args:
        jacobian: of the hand in W (6, n).
        q: joint positions (n,) [rad].
        lower: position limits (n,) [rad].
        upper: position limits (n,) [rad].
        singular_threshold: s_0, in the Jacobian's mixed units.
    """
    velocity: Array = kernels.null_space_velocity(
        _contiguous(jacobian), _contiguous(q), lower, upper, singular_threshold
    )
    return velocity


def add_null_space_velocity(
    joint_velocity: Array,
    jacobian: Array,
    q: Array,
    *,
    lower: Array,
    upper: Array,
    velocity_limits: Array,
    gain: float = GAIN,
    singular_threshold: float = SINGULAR_THRESHOLD,
    limit_horizon_s: float = LIMIT_HORIZON_S,
) -> Array:
    r"""Joint velocities with limit avoidance added (n,) [rad/s] (eq. 4.7).

    .. math:: \dot\theta' = \dot\theta + p_N \dot\theta^N

    Where the sum would exceed a velocity limit only the addition shrinks, since the hand's
    own motion goes first. What is best for the arm as a whole can push a single joint
    outward: no joint moves towards a limit faster than it would take the horizon to get there,
    and what the sum thereby loses the null space of the other joints takes over. Joint
    velocities that come in beyond the limits are bounded likewise.

    Raises:
        BadInput: a number is not finite.
    """
    velocity, J, q = _contiguous(joint_velocity), _contiguous(jacobian), _contiguous(q)
    if not (kernels.finite(velocity) and kernels.finite(J) and kernels.finite(q)):
        raise BadInput("joint velocities, Jacobian or joint positions are not finite")
    total: Array = kernels.add_avoidance(
        velocity,
        J,
        q,
        np.array((lower, upper, velocity_limits), dtype=float),
        gain,
        singular_threshold,
        limit_horizon_s,
    )
    return total


def _contiguous(array: Array) -> Array:
    return np.ascontiguousarray(array, dtype=float)
