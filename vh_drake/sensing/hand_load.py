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
    R_HW = motion.R_WH.T
    w, alpha = R_HW @ motion.w_WH, R_HW @ motion.alpha_WH
    fall = R_HW @ (GRAVITY_W - motion.a_WH)  # g - a_H
    c = inertia.p_HCom
    a_rotation = _cross(alpha, c) + _cross(w, _cross(w, c))
    force = inertia.mass * (fall - a_rotation)
    spin = inertia.I_H @ alpha + _cross(w, inertia.I_H @ w)
    torque = _cross(c, inertia.mass * fall) - spin
    return np.concatenate([torque, force])


def _cross(a: Array, b: Array) -> Array:
    """The product of two vectors; np.cross takes ten times longer, 500 times a second."""
    a_0, a_1, a_2 = a.tolist()
    b_0, b_1, b_2 = b.tolist()
    return np.array([a_1 * b_2 - a_2 * b_1, a_2 * b_0 - a_0 * b_2, a_0 * b_1 - a_1 * b_0])
