r"""Curves of the fingertip from touch to touch (section 3.3.3).

Frame T is the fingertip's: its origin touches, its z axis is the approach axis, which lies against
the outward normal of the surface when the fingertip touches squarely.

===============  ====================  =======================================
paper            code                  meaning
===============  ====================  =======================================
:math:`r`        ``p_WTip``            fingertip now
:math:`-v_n`     ``departure_W``       unit direction in which it leaves, 3.71
:math:`s_p`      ``p_WT``              target
:math:`s_n`      ``n_WT``              outward normal there
:math:`b_0..b_3` ``control_points``    (4, 3) control points
===============  ====================  =======================================
"""

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from vh_drake.errors import BadInput
from vh_drake.types import Array, TouchPlan

_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(16)


def approach_curves(p_WTip: Array, departure_W: Array | None, p_WT: Array, n_WT: Array) -> Array:
    """Control points (m, 4, 3) of the curves to targets (m, 3) with normals (m, 3), eq. 3.83.

    Without a departure direction the curve leaves straight towards its third control point.
    """
    reach = np.linalg.norm(p_WT - p_WTip, axis=1, keepdims=True) / 3.0  # k / 3, eq. 3.81
    b0 = np.broadcast_to(p_WTip, p_WT.shape)
    b2 = p_WT + reach * n_WT
    b1 = b0 + (b2 - b0) / 3.0 if departure_W is None else b0 + reach * departure_W
    return np.stack([b0, b1, b2, p_WT], axis=1)


def recovery_curve(p_WTip: Array, v_WTip: Array, p_WC: Array, n_WC: Array) -> Array:
    """Control points (4, 3) back to the last contact from below its surface, eq. 3.86.

    The signs of the inner control points are those of eq. 3.86, against a missed touch: the
    curve leaves on along the velocity and has to cross the object before the contact.

    Raises:
        BadInput: the fingertip stands still, so that no direction continues.
    """
    speed = float(np.linalg.norm(v_WTip))
    if speed < 1e-9:
        raise BadInput("fingertip velocity is zero; give the velocity with which it missed")
    reach = float(np.linalg.norm(p_WTip - p_WC)) / 3.0
    return np.stack([p_WTip, p_WTip + reach * v_WTip / speed, p_WC - reach * n_WC, p_WC])


def recovery_plan(p_WTip: Array, v_WTip: Array, p_WC: Array, n_WC: Array) -> TouchPlan:
    """The plan after a missed touch: back through the object to its last contact."""
    return TouchPlan(p_WC, -n_WC, recovery_curve(p_WTip, v_WTip, p_WC, n_WC))


def position(control_points: Array, tau: float) -> Array:
    """T(τ) of eq. 3.74 (3,); beyond τ = 1 the curve goes straight on."""
    inside = min(max(tau, 0.0), 1.0)
    powers = (1 - inside) ** np.arange(3, -1, -1) * inside ** np.arange(4) * (1, 3, 3, 1)
    beyond = (tau - inside) * velocity(control_points, inside)
    point: Array = powers @ control_points + beyond
    return point


def velocity(control_points: Array, tau: float) -> Array:
    """dT/dτ (3,), constant beyond τ = 1 (eq. 3.76 in Bernstein form)."""
    inside = min(max(tau, 0.0), 1.0)
    powers = 3.0 * np.array([(1 - inside) ** 2, 2 * inside * (1 - inside), inside**2])
    slope: Array = powers @ np.diff(control_points, axis=0)
    return slope


def arc_length(control_points: Array) -> Array:
    """Length (m,) of curves (m, 4, 3), eq. 3.66, by Gauss-Legendre quadrature [m]."""
    tau = 0.5 * (_GAUSS_NODES + 1.0)
    basis = 3.0 * np.column_stack([(1 - tau) ** 2, 2 * tau * (1 - tau), tau**2])  # (16, 3)
    speeds = np.linalg.norm(basis @ np.diff(control_points, axis=1), axis=2)  # (m, 16)
    length: Array = 0.5 * speeds @ _GAUSS_WEIGHTS
    return length


def closest_parameter(control_points: Array, p_W: Array, *, tau_from: float = 0.0) -> float:
    """The τ >= tau_from of the curve's point next to p_W (Algorithm 2, line 6).

    Exact: (T(τ) - p) · dT/dτ is a polynomial of degree five. Beyond τ = 1 the curve goes on
    straight, so that τ tells how far a fingertip has passed its target.
    """
    b0, b1, b2, b3 = control_points - p_W
    cubic = np.array([b3 - 3 * b2 + 3 * b1 - b0, 3 * b2 - 6 * b1 + 3 * b0, 3 * (b1 - b0), b0])
    slope = cubic[:3] * np.array([[3.0], [2.0], [1.0]])
    quintic = sum(np.convolve(cubic[:, i], slope[:, i]) for i in range(3))
    roots = np.roots(quintic)
    real = roots.real[np.abs(roots.imag) < 1e-9]
    end = velocity(control_points, 1.0)
    passed = 1.0 - float(b3 @ end) / max(float(end @ end), 1e-18)
    taus = [tau_from, max(1.0, tau_from), max(passed, 1.0, tau_from)]
    taus += [float(tau) for tau in real if tau_from <= tau <= 1.0]
    distances = [float(np.linalg.norm(position(control_points, tau) - p_W)) for tau in taus]
    return taus[int(np.argmin(distances))]


def aligned(R_WTip: RotationMatrix, n_WT: Array) -> RotationMatrix:
    """The orientation next to R_WTip whose approach axis lies against the normal n_WT."""
    approach = R_WTip.col(2)
    axis = np.cross(approach, -n_WT)
    sine, cosine = float(np.linalg.norm(axis)), float(-approach @ n_WT)
    if sine < 1e-9:
        axis, sine = R_WTip.col(0), 0.0  # half a turn has no preferred axis
    unit = axis / np.linalg.norm(axis)
    half = 0.5 * np.arctan2(sine, cosine)
    turn = Quaternion(np.concatenate([[np.cos(half)], np.sin(half) * unit]))
    return RotationMatrix(turn) @ R_WTip


def orientation(R_0: RotationMatrix, R_1: RotationMatrix, tau: float) -> RotationMatrix:
    """Spherical interpolation from R_0 at τ = 0 to R_1 from τ = 1 on (for eq. 3.84)."""
    share = min(max(tau, 0.0), 1.0)
    return R_0 @ RotationMatrix(Quaternion(_wxyz(share * rotation_vector(R_0.inverse() @ R_1))))


def rotation_vector(R: RotationMatrix) -> Array:
    """Axis times angle (3,) of a rotation [rad]."""
    turn = R.ToAngleAxis()
    vector: Array = turn.angle() * turn.axis()
    return vector


def _wxyz(vector: Array) -> Array:
    angle = float(np.linalg.norm(vector))
    half_sine = 0.5 * np.sinc(0.5 * angle / np.pi)  # sin(angle / 2) / angle
    return np.concatenate([[np.cos(0.5 * angle)], half_sine * vector])
