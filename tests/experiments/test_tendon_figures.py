"""Figures 4.16 to 4.18."""

import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.experiments import figure_4_16, figure_4_17, figure_4_18
from vh_drake.hand.tendon_finger import thesis_finger


@pytest.mark.parametrize("module", [figure_4_16, figure_4_17, figure_4_18])
def test_a_figure_is_drawn_and_the_same_twice(module, tmp_path):
    first = module.run(Options(out=tmp_path / "a"))
    second = module.run(Options(out=tmp_path / "b"))
    assert first == second
    pictures = [(tmp_path / out / f"{first.name}.png").read_bytes() for out in "ab"]
    assert pictures[0] == pictures[1]


def test_figure_4_16_shortens_the_tendon_by_what_its_joints_turn(tmp_path):
    for row in figure_4_16.run(Options(out=tmp_path)).rows:
        turned = sum(row[f"{joint}_deg"] for joint in figure_4_16.JOINTS)
        assert turned / 6 == pytest.approx(row["shortening_mm"], abs=1e-4)  # 15 mm a right angle


def test_figure_4_17_keeps_the_segments_lengths():
    ends = figure_4_17.segment_ends(np.array([0.3, 0.5, 0.9]))
    np.testing.assert_allclose(np.linalg.norm(np.diff(ends, axis=0), axis=1), [0.06, 0.039, 0.03])


def test_figure_4_18_closes_as_the_text_has_it_within_ten_degrees(tmp_path):
    summary = figure_4_18.run(Options(out=tmp_path)).summary
    assert summary["largest_deviation_deg"] < 10
    assert summary["others_until_40_percent_deg"] < 10


def test_what_the_text_describes_takes_up_all_of_the_tendon():
    finger, shares = thesis_finger(), np.linspace(0, 1, 11)
    angles = figure_4_18.described(finger, shares)
    np.testing.assert_allclose(angles @ finger.shortening_per_rad, shares * finger.closed_m)
