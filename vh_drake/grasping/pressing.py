"""Where a hand goes in a collecting grasp while its fingers close: down, onto the table.

A fingertip that pulls at a round object over the table gives way: its tendon turns all joints
alike, so it curls, and rides up the object's side and over it. What holds is a finger that lies
around the object, which the thesis gets by moving the hand down on almost closed fingers, so that
the table shapes them (section 4.5.4, figure 4.19 (6)). Here the thumb's tip stays just over the
table. As it folds, the hand comes down until the palm is over the object; the fingers' springs
let the table bend them around its far side, and only then do their motors pull.
"""

import dataclasses as dc
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

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
    X_TH0, pitch, p = _open(hand)
    now_pitch, now_p = _pressing(hand, hand.joint_angles(fraction))
    fingers = np.asarray(fraction)[hand.motor_of_finger][hand.opposing == 0].mean()
    left = max(1.0 - float(fingers) / _SETTINGS.eased_over, 0.0)
    X_TH = np.eye(4)
    X_TH[:3, :3] = pitched_rotation(hand, now_pitch + left * pitch)
    X_TH[:3, 3] = now_p + left * p
    offset: Array = np.linalg.inv(X_TH0) @ X_TH
    return offset


@lru_cache(maxsize=8)  # Wanted in every period of a closing hand
def _open(hand: HandModel) -> tuple[Array, float, Array]:
    """The open hand's pose, and how its pitch and position differ from a pressing hand's."""
    angles = hand.joint_angles(np.zeros(len(hand.description.motors)))
    X_TH0 = collect_pose(hand, angles, CollectSettings())
    pitch, p = _pressing(hand, angles)
    return X_TH0, _pitch_of(hand, X_TH0) - pitch, X_TH0[:3, 3] - p


def _pitch_of(hand: HandModel, X_TH: Array) -> float:
    along, palm = hand_axes(hand)
    return float(np.arctan2(-X_TH[2, :3] @ along, -X_TH[2, :3] @ palm))


def _pressing(hand: HandModel, angles: Array) -> tuple[float, Array]:
    """Pitch [rad] and position (3,) over a table z = 0 at free joint angles (n,).

    Fingertips, on average, and thumb are equally high, as far as the pitch's limits allow; the
    thumb's height then tells the hand's.
    """
    s, thumbs = _SETTINGS, hand.opposing == 1
    centers, radii = hand.spheres(angles)
    centers, radii = centers[hand.tip_spheres], radii[hand.tip_spheres]

    def heights(pitch: float) -> tuple[float, float]:
        z = centers @ pitched_rotation(hand, pitch)[2] - radii
        return float(z[~thumbs].mean()), float(z[thumbs].mean())

    def apart(pitch: float) -> float:
        fingers, thumb = heights(pitch)
        return fingers - thumb

    low, high = np.deg2rad([s.least_pitch_deg, s.most_pitch_deg])
    if apart(low) <= 0.0:
        pitch = float(low)
    elif apart(high) >= 0.0:
        pitch = float(high)
    else:
        pitch = float(brentq(apart, low, high, xtol=1e-6))
    fingers, thumb = heights(pitch)
    tcp = pitched_rotation(hand, pitch) @ np.asarray(hand.description.tcps["power"])
    height = s.clearance_m - min(thumb, fingers + s.deepest_m)
    return pitch, np.array([-tcp[0], -tcp[1], height])
