import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.experiments.figure_4_20 import Played, deviations_mm, run
from vh_drake.hand.key_points import load_key_points


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("figure")
    return run(Options(out=out)), out


def test_tips_keep_their_heights_and_the_flashlight_is_lifted(report):
    summary = report[0].summary
    assert summary["largest_deviation_mm"] < 5.0
    assert summary["rotation_deg"] == pytest.approx(25.0, abs=1.0)
    assert summary["object_raised_mm"] > 25.0
    assert summary["key_points"] == 10


def test_the_object_lies_until_it_is_enclosed(report):
    heights = {row["time_s"]: row["object_mm"] for row in report[0].rows}
    assert all(abs(mm) < 3.0 for t, mm in heights.items() if t <= 4.0)


def test_picture_and_key_points_are_written(report):
    out = report[1]
    assert (out / "figure-4.20.png").stat().st_size > 10_000
    assert len(load_key_points(out / "figure-4.20.yaml").key_points) == 11


def test_the_deviation_is_half_the_range_until_the_time_given():
    tips = np.array([[0.0, 0.010], [0.004, 0.012], [0.1, 0.1]])
    played = Played(np.array([0.0, 1.0, 2.0]), tips, np.zeros(3), np.zeros((3, 3)))
    np.testing.assert_allclose(deviations_mm(played, 1.0), [2.0, 1.0])
