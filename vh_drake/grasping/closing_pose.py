"""Where the hand goes while its fingers close, from what the motors tell."""

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
    settings = settings or CollectSettings()
    start, now = (
        collect_pose(hand, hand.joint_angles(f), settings)
        for f in (np.zeros_like(fraction), np.asarray(fraction))
    )
    offset: Array = np.linalg.inv(start) @ now
    return offset
