import dataclasses as dc

import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.experiments import figure_3_4, figure_3_17, figure_3_26, figure_3_40
from vh_drake.experiments.table_3_6 import NOISY, NOISY_WITHOUT
from vh_drake.experiments.touch_picture import curve_points, rating_colors
from vh_drake.exploration.loop import EndSettings
from vh_drake.objects import lathe

PNG = b"\x89PNG"


def run(module, folder, numbers):
    """The report of a reproduction, whose figures are checked to be pictures."""
    report = module.run(Options(out=folder))
    for number in numbers:
        assert (folder / f"figure-3.{number}.png").read_bytes().startswith(PNG)
    return report


@pytest.fixture(scope="module")
def missed():
    return figure_3_4.miss_the_edge()


def test_a_way_beyond_the_edge_meets_nothing_and_the_way_back_meets_the_side(missed):
    assert not missed.first.touched
    assert missed.first.tau > 1.0
    assert missed.second.touched
    np.testing.assert_allclose(missed.second.p_WC[0], 0.04, atol=1e-6)
    np.testing.assert_allclose(missed.second.n_WC, [1, 0, 0], atol=1e-6)
    assert -0.025 < missed.second.p_WC[1] < 0.025


def test_the_way_back_goes_on_as_the_tip_came_and_ends_at_the_last_contact_from_below(missed):
    start = missed.back[1] - missed.back[0]
    np.testing.assert_allclose(start / np.linalg.norm(start), missed.first.direction_W, atol=1e-9)
    np.testing.assert_allclose(missed.back[3], figure_3_4.CONTACTS[-1])
    assert missed.back[2][1] < missed.back[3][1]


def test_the_missed_touch_of_figure_3_20_ends_on_the_box_and_mends_the_estimate(tmp_path):
    report = run(figure_3_4, tmp_path, (4, 20))
    assert report.summary["event_on_the_object_mm"] < 0.1
    event = figure_3_4.find_event(0)
    target = event.step.touch.p_WT[None]
    before = abs(float(event.before.posterior.mean(target)[0]))
    after = float(event.step.known.posterior.mean(target)[0])
    assert before < 0.001
    assert after > 0.002  # what was thought to be the surface is known to be outside


def test_the_distance_to_the_box_is_that_of_its_faces():
    x, y, z = figure_3_4.BOX_M
    assert figure_3_4.distance_to_box(np.array([x / 2 + 0.01, 0.0, z / 2])) == pytest.approx(0.01)
    assert figure_3_4.distance_to_box(np.array([0.0, 0.0, 0.004])) == pytest.approx(0.004)
    corner = np.array([x / 2 + 0.03, y / 2 + 0.04, z / 2])
    assert figure_3_4.distance_to_box(corner) == pytest.approx(0.05)


def test_ratings_of_figure_3_17_follow_their_closed_forms():
    s = np.array([-3.0, -1.0, 0.0, 0.5, 2.0])
    psi1, psi2 = figure_3_17.profiles(s)
    np.testing.assert_allclose(psi1, 1 - np.exp(-(s**2)))
    np.testing.assert_allclose(psi2, np.exp(-((np.abs(s) - 1) ** 2)))


def test_the_plane_is_explored_outwards_in_small_steps(tmp_path):
    summary = run(figure_3_17, tmp_path, (17, 18, 19)).summary
    radii = [summary[f"radius_{part}_third_mm"] for part in ("first", "second", "last")]
    assert radii == sorted(radii)
    assert summary["full_turns"] > 1
    assert summary["median_step_mm"] < 45


def test_turns_count_angles_about_the_first_contact_without_jumps():
    angles = np.linspace(0, 5 * np.pi, 40)
    circle = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    about = np.vstack([np.zeros(3), circle]) + np.array([3.0, 4.0, 0.0])
    turned = figure_3_17.turns(about)
    assert turned[-1] - turned[0] == pytest.approx(5 * np.pi)


@pytest.fixture
def small(monkeypatch):
    """A coarse plane and few touches."""
    monkeypatch.setattr(figure_3_26, "NODES", 21)
    monkeypatch.setattr(figure_3_26, "TOUCHES", 8)
    monkeypatch.setattr(figure_3_26, "SHOWN", (3, 8))


def test_igef_goes_the_shortest_way_on_the_plane_and_gp_variance_the_longest(small):
    ways = {name: figure_3_26.explore_plane(name, 0) for name in figure_3_26.STRATEGIES}
    lengths = {name: way.length_m(8) for name, way in ways.items()}
    assert lengths["IGEF"] < lengths["RND"] < lengths["GP-V"]
    for way in ways.values():
        np.testing.assert_allclose(way.curves[:, 0], way.p[:-1])
        np.testing.assert_allclose(way.curves[:, 3], way.p[1:])
        assert len(way.ratings) == len(way.p) == 8


def test_the_next_contact_on_the_plane_is_the_best_rated_place(small):
    way = figure_3_26.explore_plane("GP-V", 0)
    for i in range(7):
        best = figure_3_26.plane_places()[np.argmax(way.ratings[i])]
        np.testing.assert_array_equal(way.p[i + 1], best)


@pytest.mark.slow
def test_a_cube_is_explored_to_the_goal_and_drawn(small, monkeypatch, tmp_path):
    cube = {"cube": lathe.box((0.05,) * 3)}
    one = {"IGEF": figure_3_26.STRATEGIES["IGEF"]}
    monkeypatch.setattr(figure_3_26, "SHAPES", {"sphere": lathe.sphere(0.03), **cube})
    monkeypatch.setattr(figure_3_26, "STRATEGIES", one)
    report = run(figure_3_26, tmp_path, (26, 27, 28))
    solids = [row for row in report.rows if row["shape"] != "plane"]
    assert [row["shape"] for row in solids] == ["sphere", "cube"]
    for row in solids:
        assert row["explored_share"] >= 0.8
        assert row["rmse_mm"] < 5
        assert row["path_cm"] > 0


@pytest.mark.slow
def test_normals_lower_both_errors_of_noisy_contacts(monkeypatch, tmp_path):
    for name, settings in (("NOISY", NOISY), ("NOISY_WITHOUT", NOISY_WITHOUT)):
        monkeypatch.setattr(figure_3_40, name, dc.replace(settings, spacing_m=0.006))
    monkeypatch.setattr(figure_3_40, "END", EndSettings())
    boxes = {"ground_coffee": lathe.cylinder(0.03, 0.08), "cheez_it": lathe.box((0.05, 0.06, 0.09))}
    monkeypatch.setattr(figure_3_40, "shape", lambda name: boxes[name])
    monkeypatch.setattr(figure_3_40, "CRACKER_M", (0.05, 0.06, 0.09))
    summary = run(figure_3_40, tmp_path, (40, 41)).summary
    assert summary["cheez_it_mm"] < summary["cheez_it_mm_without_normals"]
    assert summary["edge_rmse_mm"] < summary["edge_rmse_mm_without_normals"]
    assert set(figure_3_40.thesis()) <= set(summary)


def test_with_a_folder_the_true_meshes_are_those_in_it(tmp_path):
    mesh = lathe.box((0.06, 0.16, 0.2))
    vertices = "\n".join("v " + " ".join(map(str, p)) for p in mesh.vertices)
    faces = "\n".join("f " + " ".join(str(i + 1) for i in f) for f in mesh.faces)
    (tmp_path / "003_cracker_box.obj").write_text(vertices + "\n" + faces + "\n")
    found = figure_3_40.true_mesh("cheez_it", Options(out=tmp_path, objects=tmp_path))
    np.testing.assert_allclose(found.extents, mesh.extents)


def test_a_drawn_curve_stops_where_the_touch_did():
    line = np.linspace(0, 1, 4)[:, None] * [3.0, 0.0, 0.0]
    points = curve_points(line, 0.5)
    np.testing.assert_allclose(points[[0, -1]], [[0, 0, 0], [1.5, 0, 0]])


def test_the_best_candidate_is_green_and_what_was_not_rated_is_red():
    colors = rating_colors(np.array([-np.inf, 1.0, 5.0]))
    assert colors[2, 1] > colors[2, 0]
    assert colors[1, 0] > colors[1, 1]
    np.testing.assert_allclose(colors[0], colors[1])
