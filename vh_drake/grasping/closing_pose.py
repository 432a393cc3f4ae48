"""Where the hand goes while its fingers close, from what the motors tell."""

from functools import lru_cache

import numpy as np

from vh_drake.grasping.motions import CollectSettings, collect_pose
from vh_drake.hand.model import HandModel
from vh_drake.types import Array


def closing_offset(
    hand: HandModel, motion: str, fraction: Array, settings: CollectSettings | None = None
) -> Array:
    """Hand pose X_H0H (4, 4), relative to the open hand, at measured motor travel (k,).

    In a "collect" the hand pitches and lifts with its fingers (thesis, section 4.5.4). The
    measured travel, unlike the commanded one, stops where an object stops the fingers, so
    the hand stays with them. In other motions the hand stands still.
    """
    if motion != "collect":
        return np.eye(4)
    now = collect_pose(hand, hand.joint_angles(fraction), settings or CollectSettings())
    inverse = _inverse_of_open(hand) if settings is None else _inverse(hand, settings)
    offset: Array = inverse @ now
    return offset


def _inverse(hand: HandModel, settings: CollectSettings) -> Array:
    start = np.zeros(len(hand.description.motors))
    return np.asarray(np.linalg.inv(collect_pose(hand, hand.joint_angles(start), settings)), float)


@lru_cache(maxsize=8)  # Wanted in every period of a closing hand
def _inverse_of_open(hand: HandModel) -> Array:
    return _inverse(hand, CollectSettings())
