"""Hand motions as data: legs that an executor runs one after the other."""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.geometry.rotations import between
from vh_drake.types import Array, Immutable, TouchPlan

FAST_M_S, FAST_RAD_S = 0.30, 1.2
SLOW_M_S = 0.06


@dc.dataclass(frozen=True, eq=False)
class Leg(Immutable):
    """One piece of a motion: the hand goes straight to a pose while the motors travel."""

    name: str = ""  # shown as the phase
    X_WH: Array = dc.field(default_factory=lambda: np.eye(4))  # (4, 4) at the end
    motors: Array = dc.field(default_factory=lambda: np.zeros(0))  # (k,) fractions at the end
    duration_s: float = 1.0
    guarded: bool = False  # tares the wrist sensor first and ends at a contact
    guard_n: float = 0.0  # force that counts as one; 0 leaves it to the contact estimator
    # The hand moves up by this instead of going to X_WH.
    rise_m: float | None = None
    # The name of a closing motion: the hand then follows the fingers' measured travel.
    closing: str = ""
    # In a closing leg: the hand follows the commanded travel instead, whatever the fingers meet.
    tape: bool = False
    # In a closing leg: the hand gives way, level and up, to forces on it.
    yields: bool = False
    # In a closing leg: the hand stays where the leg before left it.
    stands: bool = False
    # The hand moves level by this towards what resisted the closing fingers; not at all where
    # nothing did.
    seek_m: float = 0.0
    # What the wrist must feel hanging on the hand at the end, or `otherwise` comes next.
    least_load_n: float = 0.0
    otherwise: tuple["Leg", ...] = ()
    # A curve for the fingertip: the trajectory follower drives, and X_WH is where it ends.
    touch: TouchPlan | None = None


@dc.dataclass(frozen=True, eq=False)
class MotionProgram(Immutable):
    """Legs with an id; a new id starts them."""

    id: int = 0
    legs: tuple[Leg, ...] = ()


@dc.dataclass(frozen=True)
class Progress(Immutable):
    """How far the executor is."""

    done: int = 0  # id of the last program that ended
    leg: str = ""  # name of the running leg
    felt: bool = False  # whether the last guarded leg ended at a contact


def travel_time(
    X_WA: Array, X_WB: Array, *, linear_m_s: float = FAST_M_S, angular_rad_s: float = FAST_RAD_S
) -> float:
    """Seconds from pose to pose at bounded mean speeds, at least a fifth of one."""
    distance = float(np.linalg.norm(X_WB[:3, 3] - X_WA[:3, 3]))
    angle = Rotation.from_matrix(X_WA[:3, :3].T @ X_WB[:3, :3]).magnitude()
    return max(distance / linear_m_s, float(angle) / angular_rad_s, 0.2)


def interpolate(X_WA: Array, X_WB: Array, share: float) -> Array:
    """Pose (4, 4) at a share 0..1 of the way: straight in position, slerp in rotation."""
    X: Array = between(
        np.ascontiguousarray(X_WA, dtype=float), np.ascontiguousarray(X_WB, dtype=float), share
    )
    return X


def smooth(share: float) -> float:
    """Minimum-jerk time scaling of a share 0..1 (Flash and Hogan 1985)."""
    s = min(max(share, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s)


def path(start: Array, poses: list[Array], names: list[str], motors: Array) -> tuple[Leg, ...]:
    """Fast legs through poses, the motors held at `motors`."""
    legs = []
    for name, pose in zip(names, poses, strict=True):
        legs.append(Leg(name, pose, motors, travel_time(start, pose)))
        start = pose
    return tuple(legs)
