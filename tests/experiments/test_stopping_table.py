import numpy as np
import pytest
from matplotlib.figure import Figure

from vh_drake.experiments.stopping import WANTED_MM, draw, fitted, shares, stops


def row(name, wanted, *, stopped, error):
    met = stopped and error <= wanted
    return {
        "object": name,
        "split": "test",
        "wanted_mm": wanted,
        "stopped": stopped,
        "met": met,
        "error_mm": error,
        "touches": 10,
    }


ROWS = [
    row("a", 2.0, stopped=True, error=1.0),
    row("a", 2.0, stopped=True, error=1.5),
    row("b", 2.0, stopped=True, error=2.5),
    row("c", 2.0, stopped=False, error=1.0),
    *(row("a", wanted, stopped=True, error=1.0) for wanted in (3.0, 5.0)),
]


def test_giving_up_and_being_wrong_both_count_as_not_met():
    summary = shares(ROWS)
    assert summary["met_share_2_mm"] == 0.5
    assert summary["objects_met_share_2_mm"] == pytest.approx(1 / 3, abs=1e-4)
    assert summary["right_when_stopped_share_2_mm"] == pytest.approx(2 / 3, abs=1e-4)
    assert summary["said_it_cannot_share_2_mm"] == 0.25
    assert summary["met_share_5_mm"] == 1.0


def test_the_fit_finds_the_weights_that_made_the_samples():
    rng = np.random.default_rng(0)
    weights = np.array([0.5, 0.7, 0.1])
    groups = []
    for _ in range(6):
        x = np.column_stack([np.ones(30), rng.normal(size=(30, 2))])
        groups.append(np.column_stack([x, np.exp(x @ weights + 0.1 * rng.normal(size=30))]))
    found = fitted(groups)
    np.testing.assert_allclose(found["fit_weights"], weights, atol=0.05)
    assert found["fit_factor_90"] == pytest.approx(np.exp(0.128), rel=0.1)
    assert fitted(groups[:1]) == {}


def test_an_exploration_gives_a_row_for_each_wanted_accuracy():
    result = stops({"object": "apple", "folder": "", "split": "library", "seed": 0})
    assert [row["wanted_mm"] for row in result["rows"]] == sorted(WANTED_MM, reverse=True)
    touches = [row["touches"] for row in result["rows"]]
    assert touches == sorted(touches)
    assert all(row["met"] for row in result["rows"])
    assert all(len(sample) == 4 for sample in result["samples"])


def test_the_figure_shows_every_run():
    axes = Figure().subplots()
    draw(axes, ROWS)
    dots, crosses, line = axes.lines
    assert len(dots.get_xdata()) == 5
    assert len(crosses.get_xdata()) == 1
    np.testing.assert_array_equal(line.get_xdata(), line.get_ydata())
