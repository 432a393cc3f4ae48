"""What users get wrong, end to end: status 2, one clear message, no traceback, nothing left."""

import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from vh_drake import cli

QUIET = ("--no-meshcat", "--no-record")
# Arguments after `vh-drake`, and what the message must say.
CASES = {
    "a missing file": (("grasp", "nowhere.obj", *QUIET), "nowhere.obj: no such file"),
    "an empty file": (("grasp", "empty.obj", *QUIET), "empty.obj"),
    "a point cloud as mesh": (("grasp", "cloud.ply", *QUIET), "cloud.ply"),
    "a mesh in millimetres": (("grasp", "millimetres.stl", *QUIET), "pass --scale 0.001"),
    "vertices that are NaN": (("grasp", "nan.obj", *QUIET), "nan.obj"),
    "an object of 2 m": (("grasp", "large.obj", *QUIET), "2 m long, too large"),
    "an unknown object": (("grasp", "mugg", *QUIET), "choose one of: "),
    "a folder as object": (("grasp", ".", *QUIET), "is a folder; pass it as --objects"),
    "a broken scenario": (("grasp", "--scenario", "broken.yaml", *QUIET), "broken.yaml"),
    "a scenario with a wrong number": (
        ("grasp", "--scenario", "wrong.yaml", *QUIET),
        "wrong.yaml: table.friction is nan; choose a value from 0 to 2",
    ),
    "a negative mass": (("grasp", "mug", "--mass", "-0.1", *QUIET), "mass_kg is -0.1; choose"),
    "an unknown hand": (("grasp", "mug", "--hand", "armar7", *QUIET), "armar6_right"),
    "a missing hand": (("grasp", "mug", "--hand", "nowhere.yaml", *QUIET), "nowhere.yaml"),
    "a missing cloud": (("plan", "nowhere.ply"), "no file at nowhere.ply"),
    "an empty cloud": (("plan", "empty.pcd"), "empty.pcd is empty"),
    "a cloud of an unknown kind": (("plan", "millimetres.stl"), "a cloud is one of .ply"),
    "a cloud that is NaN": (("plan", "nan.npz"), "are NaN or infinite"),
    "a truncated cloud": (("plan", "truncated.ply"), "truncated.ply"),
    "a leaning table": (("plan", "cloud.ply", "--table", "wall.json"), "is not vertical"),
    "a contact without normal": (
        ("plan", "cloud.ply", "--contacts", "short.csv"),
        "contact 0 has 3 values",
    ),
    "a camera nowhere": (("plan", "cloud.ply", "--camera", "nan", "0", "2"), "--camera"),
}


def write_files(folder):
    """The files that the cases name."""
    box = trimesh.creation.box((0.06, 0.1, 0.05))
    large = trimesh.creation.box((2.0, 0.1, 0.05))
    points = trimesh.PointCloud(np.random.default_rng(0).uniform(-0.05, 0.05, (500, 3)))
    box.export(folder / "box.obj")
    large.export(folder / "large.obj")
    box.apply_scale(1000.0).export(folder / "millimetres.stl")
    points.export(folder / "cloud.ply")
    (folder / "truncated.ply").write_bytes((folder / "cloud.ply").read_bytes()[:-100])
    for name in ("empty.obj", "empty.pcd"):
        (folder / name).touch()
    text = (folder / "box.obj").read_text()
    (folder / "nan.obj").write_text(text.replace("v 0.03", "v nan").replace("v -0.03", "v nan"))
    np.savez(folder / "nan.npz", points=np.full((100, 3), np.nan))
    (folder / "broken.yaml").write_text("seed: [1\n")
    (folder / "wrong.yaml").write_text("table:\n  friction: .nan\n")
    (folder / "wall.json").write_text('{"normal": [1, 0, 0], "offset": 0.9}')
    (folder / "short.csv").write_text("0.7,-0.3,0.95\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("bad_input")
    write_files(path)
    return path


def check(status, stdout, stderr, wanted):
    assert status == 2
    assert stdout == ""
    assert stderr.startswith("vh-drake: ")
    assert stderr.count("\n") == 1, stderr
    assert wanted in stderr
    assert len(stderr) < 1000


@pytest.mark.parametrize("case", CASES)
def test_unusable_input_gives_status_2_and_one_clear_message(case, folder, monkeypatch, capfd):
    arguments, wanted = CASES[case]
    before = sorted(folder.iterdir())
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", ["vh-drake", *arguments])
    with pytest.raises(SystemExit) as end:
        cli.main()
    check(end.value.code, *capfd.readouterr(), wanted)
    assert sorted(folder.iterdir()) == before


@pytest.mark.slow
@pytest.mark.parametrize("case", ["a mesh in millimetres", "a truncated cloud"])
def test_a_process_of_its_own_ends_the_same_way(case, folder):
    arguments, wanted = CASES[case]
    command = [sys.executable, "-m", "vh_drake", *arguments]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120
    )
    check(done.returncode, done.stdout, done.stderr, wanted)
