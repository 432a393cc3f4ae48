"""The commands `dataset`, `train` and `evaluate`."""

import json
import sys

import pytest
from learning_scenes import can_scene

from vh_drake import cli
from vh_drake.learning.shards import shard_bytes


def run(monkeypatch, *arguments):
    """Exit status of the command line in this process."""
    monkeypatch.setattr(sys, "argv", ["vh-drake", *map(str, arguments)])
    with pytest.raises(SystemExit) as end:
        cli.main()
    return int(end.value.code or 0)


@pytest.fixture
def folder(tmp_path):
    """A data set of one scene, without its settings."""
    (tmp_path / "scenes-00000.parquet").write_bytes(shard_bytes([can_scene()]))
    return tmp_path


def test_a_data_set_is_generated_told_of_and_verified(monkeypatch, capsys, tmp_path):
    out = tmp_path / "data"
    wishes = ("--scenes", 1, "--shapes", 1, "--no-library", "--candidates", 4, "--workers", 1)
    assert run(monkeypatch, "dataset", "generate", "--out", out, *wishes, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["scenes_wanted"] == 1
    assert run(monkeypatch, "dataset", "info", out, "--json") == 0
    assert json.loads(capsys.readouterr().out) == told
    assert run(monkeypatch, "dataset", "verify", out) == 0


def test_an_unfinished_data_set_is_not_whole(monkeypatch, capsys, folder):
    assert run(monkeypatch, "dataset", "verify", folder) == 1
    assert "not finished" in capsys.readouterr().out


def test_one_object_is_too_few_to_learn_from(monkeypatch, capsys, folder):
    status = run(monkeypatch, "train", "--dataset", folder, "--out", folder / "w", "--workers", 1)
    assert status == 2
    assert "at least two" in capsys.readouterr().err


def test_a_data_set_is_evaluated_with_the_shipped_weights(monkeypatch, capsys, folder):
    out = folder / "out"
    status = run(
        monkeypatch, "evaluate", "--dataset", folder, "--out", out, "--workers", 1, "--json"
    )
    assert status == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["name"] == "evaluate"
    assert json.loads((out / "evaluate.json").read_text()) == printed


def test_missing_data_and_weights_are_named(monkeypatch, capsys, tmp_path, folder):
    assert run(monkeypatch, "dataset", "info", tmp_path / "none") == 2
    assert "no data set" in capsys.readouterr().err
    missing = tmp_path / "none.safetensors"
    status = run(monkeypatch, "evaluate", "--dataset", folder, "--weights", missing)
    assert status == 2
    assert "no file" in capsys.readouterr().err
