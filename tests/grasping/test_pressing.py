import numpy as np
import pytest
from scenery import right_hand

from vh_drake.grasping.closing_pose import closing_offset
from vh_drake.grasping.motions import CollectSettings, collect_pose
from vh_drake.grasping.pressing import PressSettings, press_offset, presses

SETTINGS = PressSettings()
GATHERED = right_hand().description.pressing.gathered
PRESSED = right_hand().description.pressing.pressed


def over_the_table(fraction):
    """Hand pose (4, 4) over a table z = 0, and the heights of the tips in free space (f,)."""
    hand = right_hand()
    angles = hand.joint_angles(np.array(fraction))
    start = collect_pose(hand, hand.joint_angles(np.zeros(2)), CollectSettings())
    X_TH = start @ press_offset(hand, np.array(fraction))
    centers, radii = hand.spheres(angles)
    z = centers @ X_TH[2, :3] + X_TH[2, 3] - radii
    return X_TH, z[hand.tip_spheres]


def test_an_open_hand_has_not_moved():
    np.testing.assert_allclose(press_offset(right_hand(), np.zeros(2)), np.eye(4), atol=1e-12)


@pytest.mark.parametrize("fraction", [(0.25, 0.19), (0.3, 0.1), (0.4, 0.3), (0.42, 0.4)])
def test_the_thumb_stays_just_over_the_table_wherever_the_fingers_stop(fraction):
    tips = over_the_table(fraction)[1]
    thumb = tips[right_hand().opposing == 1]
    np.testing.assert_allclose(thumb, SETTINGS.clearance_m, atol=1e-6)


def test_gathering_fingertips_are_near_the_table():
    tips = over_the_table(GATHERED)[1]
    assert np.abs(tips).max() < 0.005


def test_a_folding_thumb_brings_the_hand_down_on_its_fingers():
    way = np.linspace(GATHERED, PRESSED, 5)
    heights = [over_the_table(fraction)[0][2, 3] for fraction in way]
    assert np.all(np.diff(heights) < -0.003)
    tips = over_the_table(PRESSED)[1][right_hand().opposing == 0]
    assert tips.mean() == pytest.approx(-SETTINGS.deepest_m, abs=0.005)


@pytest.mark.parametrize("fraction", [(0.1, 0.9), (0.5, 1.0), (1.0, 1.0), (0.0, 0.6)])
def test_free_fingertips_are_never_pressed_deeper_than_the_limit(fraction):
    tips = over_the_table(fraction)[1][right_hand().opposing == 0]
    assert tips.mean() >= -SETTINGS.deepest_m - 1e-9


def test_the_tool_centre_stays_over_its_spot():
    tcp = np.append(right_hand().description.tcps["power"], 1.0)
    for fraction in ([0.1, 0.1], GATHERED, PRESSED, [0.7, 0.6]):
        np.testing.assert_allclose((over_the_table(fraction)[0] @ tcp)[:2], 0.0, atol=1e-12)


def test_a_collecting_hand_presses_where_its_description_says_so():
    hand, fraction = right_hand(), np.array(PRESSED)
    assert presses(hand)
    np.testing.assert_array_equal(
        closing_offset(hand, "collect", fraction), press_offset(hand, fraction)
    )
