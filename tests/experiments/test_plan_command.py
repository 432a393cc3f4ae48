import io
import json
import sys

import numpy as np
import pytest
from experiments.plan_inputs import box_cloud, write_cloud
from matplotlib.image import imread
from sensing.synthetic_views import table, view

from vh_drake import cli
from vh_drake.errors import BadInput
from vh_drake.experiments.grasp_picture import draw_grasps
from vh_drake.experiments.plan_command import PlanRequest, plan_from_files, plan_report
from vh_drake.experiments.plan_grasps import GraspPlan
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.scenes.plant import default_hand
from vh_drake.types import Candidates, ContactSet, GraspScores, ObjectView, Plane, Surface


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("plan")


@pytest.fixture(scope="module")
def files(folder):
    return {
        "cloud": write_cloud(folder / "box.npz", box_cloud()),
        "empty table": write_cloud(folder / "bare.npz", view([table()])),
    }


def run(monkeypatch, *arguments):
    """Exit status of the command line in this process."""
    monkeypatch.setattr(sys, "argv", ["vh-drake", "plan", *map(str, arguments)])
    try:
        cli.main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0


@pytest.mark.slow
def test_the_command_writes_and_prints_the_same_plan_each_time(monkeypatch, capsys, files, folder):
    first, second = folder / "first", folder / "second"
    assert run(monkeypatch, files["cloud"], "--top", 3, "--out", first, "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    assert plan_from_files(PlanRequest(files["cloud"], top=3), second) == printed
    for name in ("plan.json", "grasps.png"):
        assert (first / name).read_bytes() == (second / name).read_bytes()
    assert printed == json.loads((first / "plan.json").read_text())
    assert set(json.loads((first / "timing.json").read_text())["seconds"]) >= {"look", "scorer"}
    assert printed["table"]["offset"] == pytest.approx(0.9, abs=0.002)
    assert printed["points"]["object"] > 500
    scores = [grasp["score"] for grasp in printed["grasps"]]
    assert len(scores) == 3
    assert scores == sorted(scores, reverse=True)
    assert np.shape(printed["grasps"][0]["X_WH"]) == (4, 4)


def test_an_empty_table_gives_status_1(monkeypatch, capsys, files, folder):
    assert run(monkeypatch, files["empty table"], "--out", folder / "none") == 1
    assert capsys.readouterr().err.startswith("vh-drake: no object on the table")
    assert not (folder / "none").exists()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"top": 0}, "--top is 0"),
        ({"seed": -1}, "--seed is -1"),
        ({"p_WCamera": (0.0, float("nan"), 1.0)}, "--camera"),
        ({"hand": "nowhere.yaml"}, "no HandDescription file at nowhere.yaml"),
        ({"contacts": "nowhere.csv"}, "no file at nowhere.csv"),
        ({"table": "nowhere.json"}, "no TableFile file at nowhere.json"),
    ],
)
def test_unusable_wishes_are_refused(files, folder, changes, message):
    with pytest.raises(BadInput, match=message):
        plan_from_files(PlanRequest(files["cloud"], **changes), folder / "refused")


def empty_plan():
    """A tetrahedron that no hand was found for."""
    vertices = 0.05 * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    return GraspPlan(
        hand=read_hand_model(load_hand(default_hand())),
        view=ObjectView(vertices, np.eye(4)[:, :3], Plane(), np.array([1.0, 0.0, 1.0])),
        contacts=ContactSet(),
        surface=Surface(vertices, faces, vertices, np.full(4, 1e-6)),
        candidates=Candidates(),
        scores=GraspScores(),
        ranking=(),
        seconds={},
    )


def test_a_plan_without_grasps_is_reported_and_drawn():
    plan = empty_plan()
    assert plan_report(plan, 10)["grasps"] == []
    assert plan_report(plan, 10)["surface"]["size"] == [0.05, 0.05, 0.05]
    image = imread(io.BytesIO(draw_grasps(plan, box_cloud())), format="png")
    assert image.shape == (650, 1300, 4)


def test_without_a_free_grasp_the_command_says_so(monkeypatch, capsys, folder):
    report = {"grasps": []}
    monkeypatch.setattr(
        "vh_drake.experiments.plan_command.plan_from_files", lambda request, out: report
    )
    assert run(monkeypatch, "box.npz", "--out", folder) == 1
    assert "no free grasp found" in capsys.readouterr().err
