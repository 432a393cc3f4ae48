"""What the arm can reach: poses by inverse kinematics, motions by rolling out the controllers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vh_drake.control import kernels
from vh_drake.control.cartesian_position import (
    GAIN_PER_S,
    MAX_ANGULAR_RAD_S,
    MAX_LINEAR_M_S,
    pose_error,
)
from vh_drake.control.cartesian_velocity import LIMIT_HORIZON_S, SINGULAR_THRESHOLD
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.null_space import GAIN as NULL_SPACE_GAIN
from vh_drake.errors import BadInput
from vh_drake.types import Array

PATIENCE_S = 0.6


@dataclass(frozen=True, eq=False)
class RolloutResult:
    """A motion of the arm under its controllers, without dynamics."""

    q: Array  # (n, 8) joint positions, one row a time step, the start first [rad]
    reached: bool  # whether every waypoint was reached
    waypoints_reached: int
    position_error_m: float  # at the end, to the waypoint that was aimed at last
    angle_error_rad: float
    duration_s: float


def rollout(
    kinematics: ArmKinematics,
    q0: Array,
    X_WH_waypoints: Sequence[Array] | Array,
    *,
    position_tolerance_m: float = 0.002,
    angle_tolerance_rad: float = 0.02,
    max_angular_rad_s: float = MAX_ANGULAR_RAD_S,
    max_linear_m_s: float = MAX_LINEAR_M_S,
    gain_per_s: float = GAIN_PER_S,
    null_space_gain: float = NULL_SPACE_GAIN,
    dt: float = 0.02,
    max_duration_s: float = 20.0,
) -> RolloutResult:
    """Drive the arm through hand poses with its three Cartesian controllers.

    A pose that this reaches is one that the simulated robot reaches, since
    the same arithmetic moves both. The motion ends where a waypoint comes no nearer for
    0.6 s.

    Args:
        kinematics: the arm.
        q0: joint positions (8,) at the start.
        X_WH_waypoints: hand poses (k, 4, 4), each reached within the tolerances in turn.
        position_tolerance_m: distance at which a waypoint counts as reached.
        angle_tolerance_rad: rotation at which it does.
        max_angular_rad_s: bound of the hand's angular velocity.
        max_linear_m_s: bound of the hand's linear velocity.
        gain_per_s: of the position controller.
        null_space_gain: p_N; 0 leaves the null-space controller out.
        dt: control period [s].
        max_duration_s: simulated time after which the rollout gives up.
    """
    waypoints = _poses(X_WH_waypoints)
    path = np.empty((int(max_duration_s / dt) + 1, len(kinematics.lower)))
    path[0] = kinematics.clamped(q0)
    gains = np.array([gain_per_s, SINGULAR_THRESHOLD, null_space_gain, LIMIT_HORIZON_S])
    tolerances = np.array([angle_tolerance_rad, position_tolerance_m, PATIENCE_S])
    bounds = np.array([max_angular_rad_s, max_linear_m_s])
    row, count = 0, 0
    for target in waypoints:
        row, reached = kernels.roll_to_pose(
            *kinematics.screws, target, kinematics.limits, bounds, gains, tolerances, dt, path, row
        )
        if not reached:
            break
        count += 1
    error = pose_error(waypoints[min(count, len(waypoints) - 1)], kinematics.pose(path[row]))
    return RolloutResult(
        q=path[: row + 1].copy(),
        reached=count == len(waypoints),
        waypoints_reached=count,
        position_error_m=float(np.linalg.norm(error[3:])),
        angle_error_rad=float(np.linalg.norm(error[:3])),
        duration_s=row * dt,
    )


def solve_ik(
    kinematics: ArmKinematics,
    X_WH: Array,
    q_seeds: Sequence[Array] | Array = (),
    *,
    restarts: int = 30,
    seed: int = 0,
    position_tolerance_m: float = 1e-4,
    angle_tolerance_rad: float = 1e-3,
) -> Array | None:
    """Joint positions (8,) within the limits that put the hand at X_WH, or None.

    Damped least squares from each of `q_seeds`, the home configuration, and then random
    configurations drawn from a generator with `seed`.
    """
    (target,) = _poses([X_WH])
    rng = np.random.default_rng(seed)
    tolerances = np.array([angle_tolerance_rad, position_tolerance_m])
    starts = [*q_seeds, kinematics.home]
    for trial in range(len(starts) + restarts):
        start = (
            starts[trial]
            if trial < len(starts)
            else rng.uniform(kinematics.lower, kinematics.upper)
        )
        q, found = kernels.refine_ik(
            *kinematics.screws,
            target,
            kinematics.clamped(start),
            kinematics.limits,
            tolerances,
            100,
        )
        if found:
            solution: Array = q
            return solution
    return None


def _poses(X_WH: Sequence[Array] | Array) -> Array:
    poses = np.ascontiguousarray(X_WH, dtype=float)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or len(poses) == 0:
        raise BadInput(f"hand poses have the shape (k, 4, 4) with k > 0, not {poses.shape}")
    if not np.isfinite(poses).all():
        raise BadInput("a hand pose holds NaN or infinite numbers; check where it came from")
    return poses
