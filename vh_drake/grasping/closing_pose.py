"""Where the hand goes while its fingers close, from what the motors tell."""

from functools import lru_cache

import numpy as np

from vh_drake.grasping.motions import CollectSettings, collect_pose
from vh_drake.grasping.pressing import press_offset, presses
from vh_drake.hand.model import HandModel
from vh_drake.types import Array


def closing_offset(hand: HandModel, motion: str, fraction: Array) -> Array:
    """Hand pose X_H0H (4, 4), relative to the open hand, at measured motor travel (k,).

    In a "collect" the hand pitches and lifts with its fingers (thesis, section 4.5.4), and
    presses them on the table where its description tells how. The measured travel, unlike the
    commanded one, stops where an object stops the fingers, so the hand stays with them. In
    other motions the hand stands still.
    """
    if motion != "collect":
        return np.eye(4)
    if presses(hand):
        return press_offset(hand, fraction)
    now = collect_pose(hand, hand.joint_angles(fraction), CollectSettings())
    offset: Array = _inverse_of_open(hand) @ now
    return offset


@lru_cache(maxsize=8)  # Wanted in every period of a closing hand
def _inverse_of_open(hand: HandModel) -> Array:
    start = np.zeros(len(hand.description.motors))
    X_TH0 = collect_pose(hand, hand.joint_angles(start), CollectSettings())
    return np.asarray(np.linalg.inv(X_TH0), float)
