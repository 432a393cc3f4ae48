r"""Feed-forward velocity control of the fingertip along a curve (section 3.1.1, Algorithm 2).

.. math::

    v_* = T_p'(\tau) + k_{p,pos} (T_p(\tau) - r) \quad (3.2), \qquad
    v_t = v_0 v_* / |v_*| \quad (3.3)

.. math:: \omega_t = \dot\tau\, T_R'(\tau) + k_{p,ori} \log(T_R(\tau) R^{-1}) \quad (3.4)

The rotations' difference is taken as axis times angle, which has no singularity.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from vh_drake.exploration.trajectory import (
    aligned,
    closest_parameter,
    orientation,
    position,
    rotation_vector,
    velocity,
)
from vh_drake.types import Array, TouchPlan


@dataclass(frozen=True)
class FollowSettings:
    """Speed, gains and when a touch counts as missed."""

    speed_m_per_s: float = 0.05  # v_0
    position_gain: float = 10.0  # k_p,pos, per unit of τ
    orientation_gain_per_s: float = 2.0  # k_p,ori
    most_turn_rad_per_s: float = 1.0
    missed_after_m: float = 0.02  # Δm


@dataclass(frozen=True, eq=False)
class FollowStep:
    """What the fingertip shall do now."""

    V_WT: Array  # (6,) angular [rad/s], then translational velocity [m/s]
    tau: float  # place on the curve, above 1 beyond its end
    missed: bool  # passed the end by more than Δm


def follow(
    plan: TouchPlan,
    R_WT0: RotationMatrix,
    X_WT: RigidTransform,
    *,
    tau_from: float,
    settings: FollowSettings,
) -> FollowStep:
    """One step of Algorithm 2: the velocity of the fingertip at a pose.

    Args:
        plan: target and curve.
        R_WT0: orientation when the motion began.
        X_WT: pose of the fingertip now.
        tau_from: the last τ, which never falls.
        settings: speed and gains.
    """
    curve, s = plan.control_points, settings
    tau = closest_parameter(curve, X_WT.translation(), tau_from=tau_from)
    slope = velocity(curve, tau)
    wanted = slope + s.position_gain * (position(curve, tau) - X_WT.translation())
    v = s.speed_m_per_s * wanted / max(float(np.linalg.norm(wanted)), 1e-12)
    tau_rate = s.speed_m_per_s / max(float(np.linalg.norm(slope)), 1e-6) if tau < 1.0 else 0.0
    w = _angular_velocity(R_WT0, aligned(R_WT0, plan.n_WT), X_WT.rotation(), tau, tau_rate, s)
    beyond = (tau - 1.0) * float(np.linalg.norm(velocity(curve, 1.0)))
    return FollowStep(np.concatenate([w, v]), tau, beyond > s.missed_after_m)


def _angular_velocity(
    R_0: RotationMatrix,
    R_1: RotationMatrix,
    R: RotationMatrix,
    tau: float,
    tau_rate: float,
    settings: FollowSettings,
) -> Array:
    """Equation 3.4 in world coordinates, bounded."""
    forward = tau_rate * rotation_vector(R_1 @ R_0.inverse())
    error = rotation_vector(orientation(R_0, R_1, tau) @ R.inverse())
    w = forward + settings.orientation_gain_per_s * error
    rate = float(np.linalg.norm(w))
    bounded: Array = w * min(1.0, settings.most_turn_rad_per_s / max(rate, 1e-12))
    return bounded
