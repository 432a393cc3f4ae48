"""Where the joints of a hand's carriage must be: three slides, then yaw, pitch and roll."""

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix

from vh_drake.grasping.motions import level_rotation
from vh_drake.hand.model import HandModel
from vh_drake.types import Array


def base_position(hand: HandModel, X_WH: Array, before: Array | None = None) -> Array:
    """Positions (6,) of the joints that put H at X_WH (4, 4).

    Place [m], then yaw, pitch and roll [rad] from the hand that lies palm down with its fingers
    along +x; at a positive pitch the fingers point down. At a pitch of 90 degrees yaw and roll
    are one.

    Args:
        hand: on the carriage.
        X_WH: wanted pose.
        before: earlier positions (6,), to which the angles stay next.
    """
    R = X_WH[:3, :3] @ level_rotation(hand).T
    angles = RollPitchYaw(RotationMatrix(R)).vector()[::-1]
    if before is not None:
        angles = angles + 2 * np.pi * np.round((before[3:] - angles) / (2 * np.pi))
    return np.concatenate([X_WH[:3, 3], angles])


def base_pose(hand: HandModel, position: Array) -> Array:
    """The inverse of `base_position`: X_WH (4, 4)."""
    X_WH = np.eye(4)
    turn = RollPitchYaw(position[:2:-1]).ToRotationMatrix().matrix()
    X_WH[:3, :3] = turn @ level_rotation(hand)
    X_WH[:3, 3] = position[:3]
    return X_WH
