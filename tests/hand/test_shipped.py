import pytest

from vh_drake.errors import UnknownName
from vh_drake.hand.description import load_hand
from vh_drake.hand.shipped import DEFAULT_HAND, hand_file, shipped_hands


def test_every_shipped_hand_is_found_under_the_name_that_it_gives_itself():
    assert DEFAULT_HAND in shipped_hands()
    for name, file in shipped_hands().items():
        assert load_hand(hand_file(name)).name == name
        assert hand_file(name) == file


def test_no_name_is_the_right_hand_of_armar6():
    assert hand_file("") == hand_file(DEFAULT_HAND)


def test_a_description_is_taken_as_it_is(tmp_path):
    plain = tmp_path / "gripper"
    plain.touch()
    assert hand_file(plain) == plain
    missing = tmp_path / "gripper.yaml"
    assert hand_file(missing) == missing


def test_an_unknown_name_is_refused_with_the_choices():
    with pytest.raises(UnknownName, match=r"unknown hand .armar7.; .* armar3_right, armar6_right"):
        hand_file("armar7")
