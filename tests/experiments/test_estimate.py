import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.errors import BadInput
from vh_drake.experiments import estimate
from vh_drake.experiments.estimate import (
    estimate_row,
    evaluated_objects,
    summarized,
    symmetric_distance,
)
from vh_drake.geometry.meshes import TriMesh
from vh_drake.objects import lathe
from vh_drake.objects.library import library_names

EMPTY = TriMesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64))


def centred(mesh):
    return TriMesh(mesh.vertices - mesh.bounds.mean(axis=0), mesh.faces)


def row(name, felt, *errors):
    return {"object": name, "felt": felt} | {f"error_{i}_mm": e for i, e in enumerate(errors)}


def test_concentric_balls_are_as_far_apart_as_their_radii_differ():
    small, large = centred(lathe.sphere(0.03)), centred(lathe.sphere(0.037))
    assert symmetric_distance(small, large) == pytest.approx(0.007, abs=1e-4)
    assert symmetric_distance(large, small) == pytest.approx(symmetric_distance(small, large))
    assert symmetric_distance(small, small) < 1e-9


def test_an_estimate_without_triangles_is_off_by_the_object_s_diagonal():
    ball = lathe.sphere(0.03)
    assert symmetric_distance(EMPTY, ball) == pytest.approx(ball.diagonal)
    assert symmetric_distance(EMPTY, EMPTY) == 0.0


def test_the_summary_holds_median_mean_and_worst_and_whether_touches_help():
    rows = [
        row("a", 5, 9.0, 3.0, 2.5, 2.0, 1.5, 1.0),
        row("a", 4, 8.0, 5.0, 4.0, 3.5, 3.0, 2.0),
        row("b", 5, 7.0, 4.0, 3.0, 2.9, 2.8, 1.9),
        row("c", None),
    ]
    summary = summarized(rows)
    assert summary["surface_error_median_mm"] == 4.0
    assert summary["surface_error_max_mm"] == 5.0
    assert summary["surface_error_max_object_mm"] == 4.0
    assert summary["surface_error_mean_0_touches_mm"] == 8.0
    assert summary["falls_with_each_touch"]
    assert summary["scenes_not_seen"] == summary["scenes_with_fewer_touches"] == 1
    rows[0]["error_5_mm"] = rows[2]["error_5_mm"] = 2.9
    assert not summarized(rows)["falls_with_each_touch"]


def test_a_scene_gives_an_error_for_every_number_of_touches(monkeypatch):
    monkeypatch.setattr(estimate, "TOUCHES", 1)
    monkeypatch.setattr(estimate, "_TRIES", 2)
    task = {"object": "apple", "folder": None, "seed": 0, "split": "library"}
    result = estimate_row(task)
    assert result["felt"] == 1
    for count in (0, 1):
        assert 0.0 < result[f"error_{count}_mm"] < 8.0
    assert estimate_row(task) == result


def test_the_library_is_evaluated_unless_a_folder_is_given(tmp_path):
    assert list(evaluated_objects(Options(out=tmp_path))) == library_names()
    with pytest.raises(BadInput):
        evaluated_objects(Options(out=tmp_path, objects=tmp_path))
