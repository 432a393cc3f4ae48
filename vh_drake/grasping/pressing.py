"""Where a hand goes in a collecting grasp while its fingers close: down, onto the table.

A fingertip that pulls at a round object over the table gives way: its tendon turns all joints
alike, so it curls, and rides up the object's side and over it. What holds is a finger that lies
around the object, which the thesis gets by moving the hand down on almost closed fingers, so that
the table shapes them (section 4.5.4, figure 4.19 (6)). Here the thumb's tip stays just over the
table. As it folds, the hand comes down until the palm is over the object; the fingers' springs
let the table bend them around its far side, and only then do their motors pull.
"""

import dataclasses as dc
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vh_drake.grasping.motions import CollectSettings, collect_pose, hand_axes, pitched_rotation
from vh_drake.hand.model import HandModel
from vh_drake.types import Array


@dc.dataclass(frozen=True)
class PressSettings:
    """The way of a pressing hand."""

    clearance_m: float = 0.001  # of the thumb's tip over the table
    least_pitch_deg: float = 3.0  # of the fingers below the horizontal
    most_pitch_deg: float = 60.0
    deepest_m: float = 0.03  # that free fingertips would be below the table, on average
    eased_over: float = 0.25  # share of the fingers' travel over which the start's height is lost


_SETTINGS = PressSettings()


def presses(hand: HandModel) -> bool:
    """Whether the hand's description says how its fingers and thumb travel while it presses."""
    return hand.description.pressing is not None


def press_offset(hand: HandModel, fraction: Array) -> Array:
    """Hand pose X_H0H (4, 4), relative to the open hand, at measured motor travel (k,).

    The open hand is where `collect_pose` has it.
    """
    start = _start(hand)
    pitch, p = _pressing(hand, hand.joint_angles(fraction))
    left = max(1.0 - float(start.fingers @ fraction) / _SETTINGS.eased_over, 0.0)
    X_TH = np.eye(4)
    X_TH[:3, :3] = pitched_rotation(hand, pitch + left * start.pitch)
    X_TH[:3, 3] = p + left * start.p
    offset: Array = start.X_H0T @ X_TH
    return offset


class _Start(NamedTuple):
    """The open hand."""

    X_H0T: Array  # (4, 4) of the table in it
    pitch: float  # by which it is pitched more than a pressing hand would be [rad]
    p: Array  # (3,) by which its place differs [m]
    fingers: Array  # (k,) share of each motor in the fingers' mean travel


@lru_cache(maxsize=8)  # Wanted in every period of a closing hand
def _start(hand: HandModel) -> _Start:
    angles = hand.joint_angles(np.zeros(len(hand.description.motors)))
    X_TH0 = collect_pose(hand, angles, CollectSettings())
    pitch, p = _pressing(hand, angles)
    motors = hand.motor_of_finger[hand.opposing == 0]
    fingers = np.bincount(motors, minlength=len(hand.description.motors)) / len(motors)
    X_H0T: Array = np.asarray(np.linalg.inv(X_TH0), float)
    return _Start(X_H0T, _pitch_of(hand, X_TH0) - pitch, X_TH0[:3, 3] - p, fingers)


def _pitch_of(hand: HandModel, X_TH: Array) -> float:
    along, palm = hand_axes(hand)
    return float(np.arctan2(-X_TH[2, :3] @ along, -X_TH[2, :3] @ palm))


def _pressing(hand: HandModel, angles: Array) -> tuple[float, Array]:
    """Pitch [rad] and position (3,) over a table z = 0 at free joint angles (n,).

    Fingertips, on average, and thumb are equally high, as far as the pitch's limits allow; the
    thumb's height then tells the hand's. A point x of H is as high as
    -(a . x) sin(pitch) - (b . x) cos(pitch), with a along the fingers and b out of the palm.
    """
    s, (along, palm), (shares, radii) = _SETTINGS, hand_axes(hand), _tips(hand)
    tips = shares @ hand.spheres(angles)[0]
    forth, out = tips @ along, tips @ palm
    apart = float(forth[0] - forth[1]), float(out[0] - out[1]), float(radii[0] - radii[1])
    pitch = _even_pitch(*apart, np.deg2rad(s.least_pitch_deg), np.deg2rad(s.most_pitch_deg))
    fingers, thumb = -forth * np.sin(pitch) - out * np.cos(pitch) - radii
    tcp = pitched_rotation(hand, pitch) @ np.asarray(hand.description.tcps["power"])
    height = s.clearance_m - min(float(thumb), float(fingers) + s.deepest_m)
    return pitch, np.array([-tcp[0], -tcp[1], height])


def _even_pitch(forth: float, out: float, radius: float, least: float, most: float) -> float:
    """Pitch [rad] at which fingers, so far from the thumb in H [m], are as high as it is.

    They are higher by -forth sin(pitch) - out cos(pitch) - radius, which falls to zero where
    pitch + atan2(out, forth) is an arc sine.
    """

    def higher(pitch: float) -> float:
        return -forth * math.sin(pitch) - out * math.cos(pitch) - radius

    if higher(least) <= 0.0:
        return least
    if higher(most) >= 0.0:
        return most
    pitch = math.asin(-radius / math.hypot(forth, out)) - math.atan2(out, forth)
    return (pitch + math.pi) % (2.0 * math.pi) - math.pi


@lru_cache(maxsize=8)
def _tips(hand: HandModel) -> tuple[Array, Array]:
    """Shares (2, m) of spheres in the mean fingertip and thumb, and these' radii (2,) [m]."""
    radii = hand.arrays.sphere_radius
    shares = np.zeros((2, len(radii)))
    for row, thumbs in enumerate((0, 1)):
        own = hand.tip_spheres[hand.opposing == thumbs]
        shares[row, own] = 1.0 / len(own)
    return shares, shares @ radii
