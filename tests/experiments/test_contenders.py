import pytest

from vh_drake.experiments.contenders import BEYOND, CONTENDERS, DEFAULT, KNOWING, subject
from vh_drake.experiments.exploration_statistics import compared, object_means


@pytest.fixture(scope="module")
def rows():
    """One exploration of an apple by one finger and by the whole hand."""
    apple = subject("apple", "")
    return [
        {"object": "apple", "split": "", "contender": name, "seed": 0, **CONTENDERS[name](apple, 0)}
        for name in ("igef", "whole_hand")
    ]


def test_what_goes_beyond_the_thesis_runs_by_default_and_is_compared_with_igef():
    assert set(BEYOND) == {"lookahead", "whole_hand"}
    assert set(BEYOND) <= set(DEFAULT) <= set(CONTENDERS)


@pytest.mark.parametrize("name", KNOWING)
def test_who_knows_the_object_runs_only_where_it_is_asked_for(name):
    assert name in CONTENDERS
    assert name not in DEFAULT
    row = CONTENDERS[name](subject("apple", ""), 0)
    assert row["end"] == "goal"
    assert row["distance_cm"] < CONTENDERS["igef"](subject("apple", ""), 0)["distance_cm"]


def test_a_hand_motion_is_counted_for_every_closing_and_the_first_touch(rows):
    hand = rows[1]
    assert hand["end"] == "goal"
    assert hand["explored_share"] >= 0.8
    assert 1 <= hand["closings"] < hand["motions"]
    touched = hand["closings"] * hand["contacts_per_closing"]
    assert touched == pytest.approx(round(touched), abs=0.01)
    assert hand["contacts"] <= touched + hand["motions"] - hand["closings"] + 0.01


def test_the_summary_compares_hand_motions_with_the_contacts_of_one_finger(rows):
    summary = compared(object_means(rows))
    expected = rows[1]["motions"] / rows[0]["contacts"]
    assert summary["whole_hand_over_igef_mean_ratio"] == pytest.approx(expected, abs=1e-4)
    assert summary["whole_hand_over_igef_mean_ratio"] < 0.6
    assert summary["whole_hand_contacts_per_closing"] >= 2.0
