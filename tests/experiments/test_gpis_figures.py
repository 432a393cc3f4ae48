import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.experiments import figure_3_1, figure_3_5, figure_3_11, figure_3_13
from vh_drake.experiments.edge_picture import box_edges, edge_rmse
from vh_drake.objects import lathe

PNG = b"\x89PNG"


def run(module, folder, numbers):
    """The report of a reproduction, whose figures are checked to be pictures."""
    report = module.run(Options(out=folder))
    for number in numbers:
        assert (folder / f"figure-3.{number}.png").read_bytes().startswith(PNG)
    return report


def test_balance_travels_less_than_half_for_the_same_coverage(tmp_path):
    summary = run(figure_3_1, tmp_path, (1, 2, 3)).summary
    assert summary["path_ratio"] < 0.5
    ratio = summary["balanced_mean_distance_mm"] / summary["greedy_mean_distance_mm"]
    assert ratio == pytest.approx(1.0, abs=0.15)


def test_coverage_is_the_mean_distance_to_the_nearest_touch():
    progress = figure_3_1.Progress(np.array([[0.0, 0.0], [0.05, 0.05]]))
    places = figure_3_1.region()
    brute = [min(np.hypot(*(x - c)) for c in progress.p) for x in places]
    assert progress.coverage_m(2) == pytest.approx(np.mean(brute))
    assert progress.lengths_m[-1] == pytest.approx(np.hypot(0.05, 0.05))


def test_the_greedy_explorer_goes_to_the_corners_after_the_centre():
    p = figure_3_1.explore("greedy").p
    np.testing.assert_allclose(p[0], figure_3_1.SIDE_M / 2)
    corners = {tuple(np.round(x / figure_3_1.SIDE_M, 6)) for x in p[1:5]}
    assert corners == {(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)}


def test_weights_are_those_of_table_3_3_to_its_last_digit(tmp_path):
    report = run(figure_3_5, tmp_path, range(5, 11))
    assert report.summary["table_3_3_largest_difference"] <= 0.005001


def test_weights_solve_the_linear_system():
    places = figure_3_5.PLACES.copy()
    places[3] = places[2] + 0.25
    K = np.exp(-0.5 * np.subtract.outer(places, places) ** 2)
    row = figure_3_5.weights_row(0.25)
    expected = np.linalg.solve(K, figure_3_5.VALUES)
    np.testing.assert_allclose([row[f"w{i}"] for i in range(1, 6)], expected, rtol=1e-5)


def test_normals_lower_the_error_of_every_example(tmp_path):
    for row in run(figure_3_11, tmp_path, (11, 12)).rows:
        assert row["mm"] < row["mm_without_normals"]


def test_outline_and_its_error_are_those_of_a_known_line():
    truth = figure_3_11.outline(np.array([[-0.05, 0.0], [0.05, 0.0]]))
    assert np.diff(truth[:, 0]).max() < 0.001
    posterior = figure_3_11.estimate(figure_3_11.FLAT, normals=True)
    shifted = truth + np.array([0.0, 0.003])
    assert figure_3_11.error_in_plane(posterior, truth) < 0.0002
    assert figure_3_11.error_in_plane(posterior, shifted) == pytest.approx(0.003, abs=0.0002)


def test_variance_is_halved_after_seven_touches_as_in_the_text(tmp_path):
    summary = run(figure_3_13, tmp_path, range(13, 17)).summary
    assert summary["variance_halved_after_touches"] == 7
    assert abs(summary["variance_based_leads_after_touches"] - 15) <= 1
    assert summary["rmse_variance_based_after_20"] < summary["rmse_linear_after_20"]


def test_edges_of_a_box_lie_on_it():
    size = (0.1, 0.06, 0.04)
    edges = box_edges(size)
    np.testing.assert_allclose(edges.min(axis=0), [-0.05, -0.03, 0.0], atol=1e-12)
    np.testing.assert_allclose(edges.max(axis=0), [0.05, 0.03, 0.04], atol=1e-12)
    assert edge_rmse(lathe.box(size), edges) < 1e-9
