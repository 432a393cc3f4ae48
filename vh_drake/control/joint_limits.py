"""What the joints themselves allow: no limit is exceeded, whatever is asked for."""

import numpy as np

from vh_drake.control import kernels
from vh_drake.errors import BadInput
from vh_drake.types import Array

PERIOD_S = 0.005  # of the commands to the arm


def limited_joint_velocity(
    wanted: Array, q: Array, velocity: Array, limits: Array, *, period_s: float = PERIOD_S
) -> Array:
    r"""Joint velocities (n,) [rad/s] for the next period, as near to the wanted ones as may be.

    They lie on the straight way from the present velocities to the wanted ones, so that the
    hand's velocity goes straight from one to the other too, and are bounded joint by joint by

    .. math:: -\dot\theta_{max} \le \dot\theta \le \dot\theta_{max}, \quad
        |\dot\theta - \dot\theta_{now}| \le a T, \quad
        \dot\theta \le \sqrt{2 a (\theta^+ - \theta)} - a T / 2

    with the acceleration limit a and the period T. The last one, and its mirror image at the
    lower limit, leave the joint room to stop before its limit; within one period of it the bound
    is min(d / T, a T), d being the distance. A state that breaks these bounds already is led
    back: position limits go before velocities, and these before accelerations.

    Args:
        wanted: joint velocities (n,) [rad/s].
        q: joint positions (n,) [rad].
        velocity: joint velocities now (n,) [rad/s].
        limits: rows lower, upper [rad], velocity [rad/s], acceleration [rad/s^2]; (4, n).
        period_s: T.

    Raises:
        BadInput: a number is not finite, or the shapes differ.
    """
    w, q, v = (np.ascontiguousarray(x, dtype=float) for x in (wanted, q, velocity))
    _check(w, q, v)
    result: Array = kernels.limited_change(w, q, v, limits, period_s)
    return result


def next_joint_state(
    wanted: Array, state: Array, limits: Array, *, period_s: float = PERIOD_S
) -> Array:
    """Joint positions, then velocities (2 n,) [rad, rad/s] after a period.

    The velocities are those of `limited_joint_velocity`, the positions their sum.

    Args:
        wanted: joint velocities (n,) [rad/s].
        state: positions, then velocities now (2 n,).
        limits: as of `limited_joint_velocity`.
        period_s: of the step [s].

    Raises:
        BadInput: a number is not finite, or the shapes don't fit.
    """
    w, x = (np.ascontiguousarray(given, dtype=float) for given in (wanted, state))
    n = len(w)
    _check(w, x[:n], x[n:])
    after: Array = kernels.next_state(w, x, limits, period_s)
    return after


def _check(wanted: Array, q: Array, velocity: Array) -> None:
    finite = kernels.finite(wanted) and kernels.finite(q) and kernels.finite(velocity)
    if not (finite and wanted.shape == q.shape == velocity.shape):
        raise BadInput(
            "joint velocities and positions must be finite and of the same number, not "
            f"{wanted.tolist()}, {q.tolist()}, {velocity.tolist()}"
        )
