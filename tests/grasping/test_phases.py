import pytest

from vh_drake.grasping.phases import hand_is_open


@pytest.mark.parametrize("phase", ["", "look", "touch: feel", "plan grasps", "grasp: approach"])
def test_before_a_grasp_closes_the_hand_is_open(phase):
    assert hand_is_open(phase)


@pytest.mark.parametrize("phase", ["grasp: gather", "grasp: close", "grasp: lift", "done"])
def test_from_the_closing_on_it_is_not(phase):
    assert not hand_is_open(phase)
