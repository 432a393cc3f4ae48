"""How hand and fingers move together in free space while a grasp closes.

Both motions run over a time t from 0 to 1. *side* keeps the hand still while all fingers
close. *collect* keeps the hand's lowest point just over the table: the hand pitches so that
the line from the fingertips to the thumb's tip stays parallel to the table, and rises as the
fingers fold under it (thesis, section 4.5.4).
"""

import dataclasses as dc
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import interp1d

from vh_drake.errors import BadInput
from vh_drake.grasping.bunch_paths import BunchPaths, bunch_paths
from vh_drake.grasping.bunches import Bunches, bunches_of
from vh_drake.hand.kinematics import link_poses
from vh_drake.hand.model import HandModel
from vh_drake.types import Array

MOTIONS = ("collect", "side", "free")
_SHORTEST_LINE_M = 0.06
_FINER = 4  # paths of fingertips between two knots leave a straight line by at most 0.1 mm then


@dc.dataclass
class CollectSettings:
    """The collecting grasp from the top."""

    clearance_m: float = 0.004  # lowest point of the hand over the table
    min_pitch_deg: float = 15.0  # of the fingers below the horizontal
    max_pitch_deg: float = 60.0
    first_fingers: float = 0.5  # share of the fingers' travel at t = 0.5
    first_thumb: float = 0.2  # share of the thumb's travel at t = 0.5
    knots: int = 17


class MotionArrays(NamedTuple):
    """A motion at k evenly spaced times; between them positions follow straight lines."""

    X_H0H: Array  # (k, 3, 4) hand in its start pose
    angles: Array  # (k, n) free-space joint angles
    moving: bool  # whether the hand moves at all
    bunches: Bunches  # of the hand's m spheres
    paths: BunchPaths  # of these at the k times
    open_ball: Array  # (b, 3) where the bunches' balls are on the open hand, in H [m]
    open_sphere: Array  # (m, 3) and its spheres


def side_motion(hand: HandModel) -> MotionArrays:
    """All fingers close together while the hand stands still."""
    fractions = np.linspace(0, 1, 17)[:, None] * np.ones(len(hand.description.motors))
    return _motion(hand, np.tile(np.eye(4)[:3], (17, 1, 1)), hand.joint_angles(fractions))


def collect_motion(hand: HandModel, settings: CollectSettings) -> MotionArrays:
    """The collecting motion; the power TCP stays over the same spot of the table."""
    times = np.linspace(0, 1, settings.knots)
    fingers = np.interp(times, [0, 0.5, 1], [0, settings.first_fingers, 1])
    thumbs = np.interp(times, [0, 0.5, 1], [0, settings.first_thumb, 1])
    pairs = zip(fingers, thumbs, strict=True)
    angles = hand.joint_angles(np.array([hand.motor_fractions(f, t) for f, t in pairs]))
    X_TH = np.array([collect_pose(hand, q, settings) for q in angles])
    return _motion(hand, (np.linalg.inv(X_TH[0]) @ X_TH)[:, :3], angles)


def collect_pose(hand: HandModel, angles: Array, settings: CollectSettings) -> Array:
    """Hand pose (4, 4) over a table z = 0 at joint angles (n,), fingers along +x.

    The power TCP is over the origin; rotate about z and shift in x and y as needed.
    """
    pitch = np.clip(
        tip_line_pitch(hand, angles),
        np.deg2rad(settings.min_pitch_deg),
        np.deg2rad(settings.max_pitch_deg),
    )
    X = np.eye(4)
    X[:3, :3] = pitched_rotation(hand, float(pitch))
    centers, radii = hand.spheres(angles)
    lowest = float((centers @ X[2, :3] - radii).min())
    tcp = X[:3, :3] @ np.asarray(hand.description.tcps["power"])
    X[:3, 3] = [-tcp[0], -tcp[1], settings.clearance_m - lowest]
    return X


def pitched_rotation(hand: HandModel, pitch: float) -> Array:
    """Rotation (3, 3) with the palm down and the fingers along +x, pointing down by `pitch`."""
    c, s = np.cos(pitch), np.sin(pitch)
    rotation: Array = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ level_rotation(hand)
    return rotation


@lru_cache(maxsize=8)
def level_rotation(hand: HandModel) -> Array:
    """That of a hand which lies flat; not writable."""
    along, palm = hand_axes(hand)
    R_H = np.stack([along, np.cross(-palm, along), -palm])  # rows: forward, left, up
    R_H.setflags(write=False)
    return R_H


def tip_line_pitch(hand: HandModel, angles: Array) -> float:
    """Pitch [rad] at which the line from fingertips to thumb tip is parallel to the table.

    Where the tips come near each other, or pass, the line has no direction of its own; it is
    then taken as 6 cm long, which keeps the pitch smooth.
    """
    along, palm = hand_axes(hand)
    centers, radii = hand.spheres(angles)
    tips = hand.tip_spheres
    thumbs = hand.opposing == 1
    if thumbs.all() or not thumbs.any():
        return 0.0
    ends = [
        (centers[tips[side]] + radii[tips[side], None] * palm).mean(axis=0)
        for side in (~thumbs, thumbs)
    ]
    line = ends[0] - ends[1]
    return float(np.arctan2(-(line @ palm), max(line @ along, _SHORTEST_LINE_M)))


@lru_cache(maxsize=8)  # Asked for in every period of a closing hand
def hand_axes(hand: HandModel) -> tuple[Array, Array]:
    """Unit vectors along the fingers and out of the palm, made orthogonal, in H; not writable.

    Raises:
        BadInput: the description's directions are zero or parallel.
    """
    along = np.asarray(hand.description.along, np.float64)
    palm = np.asarray(hand.description.palm, np.float64)
    if np.linalg.norm(np.cross(along, palm)) < 1e-6:
        raise BadInput(f"hand: along {along} and palm {palm} must be two different directions")
    along = along / np.linalg.norm(along)
    palm = palm - (palm @ along) * along
    palm /= np.linalg.norm(palm)
    along.flags.writeable = palm.flags.writeable = False
    return along, palm


def motion_of(name: str, hand: HandModel, collect: CollectSettings) -> MotionArrays:
    """The motion of a candidate by its name."""
    return collect_motion(hand, collect) if name == "collect" else side_motion(hand)


def _motion(hand: HandModel, X_H0H: Array, angles: Array) -> MotionArrays:
    """The motion through knots, at finer times, so that spheres go straight between them."""
    knots = np.arange(len(angles))
    times = np.linspace(0, knots[-1], _FINER * knots[-1] + 1)
    poses = interp1d(knots, X_H0H, axis=0)(times)
    fine = np.ascontiguousarray(interp1d(knots, angles, axis=0)(times))
    bunches = bunches_of(hand.arrays)
    X_HB = link_poses(hand.arrays, np.eye(4), fine[0])[bunches.link]
    X_HS = np.repeat(X_HB, np.diff(bunches.first_sphere), axis=0)
    return MotionArrays(
        X_H0H=np.ascontiguousarray(poses),
        angles=fine,
        moving=bool(np.ptp(X_H0H, axis=0).max() > 1e-9),
        bunches=bunches,
        paths=bunch_paths(hand.arrays, bunches, poses, fine),
        open_ball=_placed(X_HB, bunches.ball_center),
        open_sphere=_placed(X_HS, bunches.sphere_center),
    )


def _placed(X: Array, p: Array) -> Array:
    """Points (n, 3), each in a frame of its own X (n, 3, 4)."""
    placed: Array = np.einsum("nij,nj->ni", X[..., :3], p) + X[..., 3]
    return placed
