import json
import sys

import numpy as np
import pytest

from vh_drake import cli
from vh_drake.errors import BadInput, UnknownName
from vh_drake.experiments.exploration_pictures import share_at
from vh_drake.experiments.explore_command import ExploreRequest, explore_object
from vh_drake.objects import lathe

CENTER = (0.0, 0.0, 0.03)  # shapes stand on the plane z = 0


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    path = tmp_path_factory.mktemp("mesh") / "ball.ply"
    lathe.sphere(0.03).to_trimesh().export(path)
    return path


def status(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["vh-drake", "explore", *map(str, arguments)])
    with pytest.raises(SystemExit) as end:
        cli.main()
    return int(end.value.code or 0)


def test_an_explored_ball_is_told_in_numbers_a_picture_and_a_recording(ball, tmp_path):
    report = explore_object(ExploreRequest(str(ball), seed=1), tmp_path, record=True)
    assert report["reached"]
    assert report["explored_share"] >= 0.8
    assert len(report["touches"]) == report["contacts"] - 1
    ways = [touch["length_cm"] for touch in report["touches"]]
    assert report["distance_cm"] == pytest.approx(sum(ways), abs=1e-3)
    for touch in report["touches"]:  # the ball's radius, within its facets
        assert np.linalg.norm(np.subtract(touch["position_m"], CENTER)) == pytest.approx(
            0.03, abs=3e-4
        )
    assert json.loads((tmp_path / "explore.json").read_text()) == report
    assert (tmp_path / "explore.png").stat().st_size > 20_000
    assert b"</html>" in (tmp_path / "recording.html").read_bytes()


def test_the_same_request_writes_the_same_bytes(ball, tmp_path):
    for name in ("a", "b"):
        request = ExploreRequest(str(ball), strategy="random", touches=3)
        explore_object(request, tmp_path / name, record=False)
    for file in ("explore.json", "explore.png"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_a_goal_that_was_not_reached_gives_status_1_and_pure_json(
    ball, tmp_path, monkeypatch, capsys
):
    options = ("--touches", 2, "--no-record", "--out", tmp_path, "--json")
    assert status(monkeypatch, ball, *options) == 1
    report = json.loads(capsys.readouterr().out)
    assert (report["end"], report["reached"], report["contacts"]) == ("touches", False, 3)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("ball.glb",), "ball.glb"),
        (("moon",), "banana"),
        (("ball", "--touches", 0), "--touches"),
        (("ball", "--goal", 1.5), "--goal"),
        (("ball", "--seed", -1), "--seed"),
        (("ball", "--strategy", "greedy"), "potential_field"),
    ],
)
def test_unusable_input_gives_status_2_and_names_it(options, word, tmp_path, monkeypatch, capsys):
    assert status(monkeypatch, *options, "--out", tmp_path / "out") == 2
    told = capsys.readouterr()
    assert word in told.err
    assert not told.out
    assert not (tmp_path / "out").exists()


def test_errors_are_ours_before_anything_is_written(tmp_path):
    with pytest.raises(BadInput, match="--goal"):
        explore_object(ExploreRequest("ball", goal=0.0), tmp_path / "out", record=False)
    with pytest.raises(UnknownName, match="igef"):
        explore_object(ExploreRequest("ball", strategy="x"), tmp_path / "out", record=False)
    assert not (tmp_path / "out").exists()


def test_a_finished_run_keeps_its_last_share():
    distances, shares = np.array([0.0, 2.0, 5.0]), np.array([0.1, 0.4, 0.8])
    at = np.array([0.0, 1.9, 2.0, 4.0, 9.0])
    np.testing.assert_array_equal(share_at(distances, shares, at), [0.1, 0.1, 0.4, 0.4, 0.8])
