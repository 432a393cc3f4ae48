r"""What the hand's own weight and motion put on the wrist sensor.

The sensor sits at the hand's base H. By convention its wrench :math:`w = [\tau; f]` is the
load that the hand puts on the arm, expressed in H, torque about H's origin:

.. math:: f = F_{ext} + m (g - a_{com}), \qquad
          \tau = \tau_{ext} + c \times m g - (c \times m a_H + I \alpha + \omega \times I \omega)

with mass m, centre of mass c and rotational inertia I about H's origin. So a hand that hangs
at rest shows its weight (f points down), and what pushes the hand adds as it pushes.
"""

import dataclasses as dc

import numpy as np
from numba import njit

from vh_drake.types import Array

GRAVITY_W = np.array([0.0, 0.0, -9.81])  # [m/s^2]


@dc.dataclass(frozen=True, eq=False)
class HandInertia:
    """Mass properties of all that hangs on the wrist sensor, fingers included."""

    mass: float = 0.985765  # [kg], the hand of ARMAR-6
    p_HCom: Array = dc.field(default_factory=lambda: np.array([0.015, 0.0, -0.025]))  # [m]
    I_H: Array = dc.field(default_factory=lambda: np.zeros((3, 3)))  # about Ho in H [kg m^2]


@dc.dataclass(frozen=True, eq=False)
class HandMotion:
    """Motion of the hand's base H in W, expressed in W."""

    R_WH: Array  # (3, 3)
    w_WH: Array  # (3,) [rad/s]
    alpha_WH: Array  # (3,) [rad/s^2]
    a_WH: Array  # (3,) acceleration of H's origin [m/s^2]


def own_load(inertia: HandInertia, motion: HandMotion) -> Array:
    """Wrench (6,) [N m; N] in H, as the sensor shows it without any contact.

    Degenerate case: at rest only the weight remains.
    """
    return load_of(
        inertia.mass,
        inertia.p_HCom,
        inertia.I_H,
        motion.R_WH,
        motion.w_WH,
        motion.alpha_WH,
        motion.a_WH,
    )


@njit(cache=True)
def load_of(
    mass: float, c: Array, I_H: Array, R_WH: Array, w_W: Array, alpha_W: Array, a_W: Array
) -> Array:
    """`own_load` of plain numbers, for compiled code."""
    R_HW = np.ascontiguousarray(R_WH.T)
    w, alpha = R_HW @ w_W, R_HW @ alpha_W
    fall = R_HW @ (GRAVITY_W - a_W)  # g - a_H
    a_rotation = cross(alpha, c) + cross(w, cross(w, c))
    load = np.empty(6)
    load[3:] = mass * (fall - a_rotation)
    load[:3] = cross(c, mass * fall) - (I_H @ alpha + cross(w, I_H @ w))
    return load


@njit(cache=True)
def shifted_wrench(R_HJ: Array, p_HJ: Array, torque_J: Array, force_J: Array) -> Array:
    """Wrench (6,) [N m; N] about Ho in H of a torque (3,) and a force (3,) at Jo, in J."""
    wrench = np.empty(6)
    wrench[3:] = R_HJ @ force_J
    wrench[:3] = R_HJ @ torque_J + cross(p_HJ, wrench[3:])
    return wrench


@njit(cache=True)
def cross(a: Array, b: Array) -> Array:
    """The product of two vectors (3,)."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
