import pytest

from vh_drake.catalog import Options
from vh_drake.experiments import example_objects, figure_3_30, figure_3_36
from vh_drake.experiments.example_objects import STRATEGIES, example_runs


@pytest.fixture(autouse=True)
def ball_alone(monkeypatch):
    monkeypatch.setattr(example_objects, "_EXAMPLES", (("054_softball", "ball"),))


@pytest.mark.parametrize("figure", [figure_3_30, figure_3_36])
def test_every_strategy_explores_every_run_and_pictures_are_written(figure, tmp_path):
    report = figure.run(Options(runs=2, out=tmp_path, workers=1))
    assert report.settings["objects"] == ["ball"]
    assert {(row["strategy"], row["seed"]) for row in report.rows} == {
        (strategy, seed) for strategy in STRATEGIES for seed in (0, 1)
    }
    assert (tmp_path / f"{report.name}.png").read_bytes().startswith(b"\x89PNG")
    again = figure.run(Options(runs=2, out=tmp_path, workers=1))  # From the journal.
    assert again.rows == report.rows


def test_without_a_folder_the_library_s_own_stand_in(tmp_path):
    assert example_objects.example_objects(Options(out=tmp_path)) == {"ball": ""}


def test_one_exploration_is_the_same_again_and_another_seed_differs():
    first, second = example_runs("ball", "", "igef", [0, 1])
    (again,) = example_runs("ball", "", "igef", [0])
    assert again.lengths_m.tolist() == first.lengths_m.tolist()
    assert second.lengths_m.tolist() != first.lengths_m.tolist()
