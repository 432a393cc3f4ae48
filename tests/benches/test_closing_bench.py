from dataclasses import replace

import numpy as np
import pytest

from vh_drake.benches import closing
from vh_drake.benches.closing import compared, run, shift, summarized, timed
from vh_drake.catalog import Options
from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.grasping.closing import Closure
from vh_drake.grasping.field import object_field
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.learning.labels import LabelSettings, nominal_closures
from vh_drake.objects.library import library_object
from vh_drake.types import Candidates, Plane, Surface

FAR_BELOW = Plane(np.array([0.0, 0, 1]), -10.0)


@pytest.fixture(scope="module")
def hand():
    return read_hand_model(load_hand(hand_file()))


@pytest.fixture(scope="module")
def ball():
    mesh = library_object("ball").mesh
    middle = np.array([-0.045, -0.005, 0.03]) - mesh.bounds.mean(axis=0)
    return TriMesh(mesh.vertices + middle, mesh.faces)


def field_of(mesh, spacing_m):
    surface = Surface(mesh.vertices, mesh.faces)
    return object_field(surface, FAR_BELOW, spacing_m=spacing_m, padding_m=0.015)


def around(*shifts):
    """Side grasps, moved along x."""
    X = np.tile(np.eye(4), (len(shifts), 1, 1))
    X[:, 0, 3] = shifts
    return Candidates(X, ("side",) * len(shifts), ("surface",) * len(shifts))


def closure(links, p):
    links = np.array(links)
    return Closure(
        True, np.array(p, float), np.zeros((len(links), 3)), links, np.zeros(1), np.eye(4)
    )


def test_the_bench_reports_speed_agreement_and_contacts(monkeypatch, tmp_path):
    for name, value in (("CANDIDATES", 12), ("TRIALS", 20), ("FINE_M", 0.001)):
        monkeypatch.setattr(closing, name, value)
    summary = run(Options(out=tmp_path, runs=1)).summary
    assert summary["closings_per_s"] > 2000
    assert summary["label_agreement"] > 0.8
    assert summary["contact_off_mesh_median_mm"] < 0.05
    assert summary["labels"] == 12


def test_starts_in_collision_are_not_timed(hand, ball):
    field = field_of(ball, 0.003)
    closings, ms = timed(around(0.0, 0.002, -0.09), field, hand)
    closures = nominal_closures(around(0.0, 0.002, -0.09), field, hand, LabelSettings())
    free = [one.started_free for one in closures]
    assert closings == sum(free) == 2
    assert ms > 0


def test_a_grid_agrees_with_itself(hand, ball):
    field, candidates = field_of(ball, 0.002), around(0.0, 0.002, 0.004)
    row = compared(candidates, (field, field), ball, hand, 0)
    assert row["labels_agree"] == row["labels"] == 3
    assert row["shift_mm"] == 0.0


def test_contacts_leave_the_mesh_by_no_more_than_a_chord_of_a_cell_does(hand, ball):
    radius, spacing = ball.extents.max() / 2, 0.002
    candidates = around(0.0, 0.002, 0.004)
    row = compared(candidates, (field_of(ball, spacing),) * 2, ball, hand, 0)
    assert row["contacts"] >= 9
    assert row["off_mesh_mm"] < 1e3 * spacing**2 / (4 * radius)


def test_only_links_that_touch_in_both_closings_are_compared():
    one = closure([1, 2, 5], [[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    other = closure([2, 5, 7], [[1, 0, 3], [2, 4, 0], [9, 9, 9]])
    np.testing.assert_allclose(shift(one, other), [3, 4])
    assert len(shift(one, replace(other, links=np.array([8, 9, 10])))) == 0


def test_the_summary_weighs_objects_by_their_closings():
    rows = [
        {"object": "a", "closings": 100, "closings_per_s": 10_000},
        {"object": "b", "closings": 300, "closings_per_s": 30_000},
        {"object": "c", "candidates": 0},
    ]
    summary = summarized(rows)
    assert summary["closings_per_s"] == 20_000
    assert summary["closings_per_s_slowest"] == 10_000
    assert summary["objects_without_fine_grid"] == 3
    with pytest.raises(BadInput, match="can be grasped"):
        summarized(rows[2:])
