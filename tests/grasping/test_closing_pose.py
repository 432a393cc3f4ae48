import dataclasses as dc

import numpy as np
import pytest
from scenery import right_hand

from vh_drake.grasping.closing_pose import closing_offset
from vh_drake.grasping.motions import CollectSettings, collect_motion, collect_pose


@pytest.fixture(scope="module")
def gliding():
    """A hand that does not press on the table."""
    hand = right_hand()
    return dc.replace(hand, description=dc.replace(hand.description, pressing=None))


def lowest(X_WH, angles):
    centers, radii = right_hand().spheres(angles)
    return float((centers @ X_WH[2, :3] + X_WH[2, 3] - radii).min())


def test_an_open_hand_has_no_offset():
    np.testing.assert_allclose(
        closing_offset(right_hand(), "collect", np.zeros(2)), np.eye(4), atol=1e-12
    )


@pytest.mark.parametrize("fraction", [(0.3, 0.1), (0.5, 0.2), (1.0, 1.0), (0.4, 0.0)])
def test_wherever_the_fingers_stop_the_hand_stays_over_the_table(gliding, fraction):
    hand, settings = gliding, CollectSettings()
    start = collect_pose(hand, hand.joint_angles(np.zeros(2)), settings)
    X_WH = start @ closing_offset(hand, "collect", np.array(fraction))
    angles = hand.joint_angles(np.array(fraction))
    assert lowest(X_WH, angles) == pytest.approx(settings.clearance_m, abs=1e-9)


def test_free_fingers_move_the_hand_as_the_planned_motion_does(gliding):
    hand, settings = gliding, CollectSettings()
    motion = collect_motion(hand, settings)
    half = hand.motor_fractions(settings.first_fingers, settings.first_thumb)
    np.testing.assert_allclose(
        closing_offset(hand, "collect", half)[:3], motion.X_H0H[len(motion.X_H0H) // 2], atol=1e-9
    )
    np.testing.assert_allclose(
        closing_offset(hand, "collect", np.ones(2))[:3], motion.X_H0H[-1], atol=1e-9
    )


def test_in_a_side_grasp_the_hand_stands_still():
    np.testing.assert_array_equal(
        closing_offset(right_hand(), "side", np.array([0.7, 0.7])), np.eye(4)
    )
