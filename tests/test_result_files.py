import json

import pytest

from vh_drake import atomic_files
from vh_drake.errors import BadInput, VhDrakeError
from vh_drake.result_files import write_json, write_text


def test_an_object_comes_back_as_it_was_and_its_folders_are_made(tmp_path):
    path = tmp_path / "a" / "b" / "result.json"
    content = {"seed": 3, "touches": [{"felt": True}], "slip_mm": None, "name": "Körper"}
    write_json(path, content)
    assert json.loads(path.read_text()) == content
    assert path.read_text().endswith("}\n")
    assert list(path.parent.iterdir()) == [path]


def test_the_same_object_gives_the_same_bytes(tmp_path):
    content = {"b": 0.1 + 0.2, "a": [1, 2]}
    for name in ("first", "second"):
        write_json(tmp_path / name, content)
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()


def test_text_is_utf_8_with_its_line_ends_untouched(tmp_path):
    write_text(tmp_path / "a", "ψ\n")
    assert (tmp_path / "a").read_bytes() == b"\xcf\x88\n"


def test_what_json_can_not_say_leaves_the_old_file(tmp_path):
    path = tmp_path / "result.json"
    write_json(path, {"a": 1})
    with pytest.raises(TypeError):
        write_json(path, {"a": 2, "b": object()})
    assert json.loads(path.read_text()) == {"a": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_leaves_the_old_file_and_no_rest(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    path = tmp_path / "result.json"
    write_json(path, {"a": 1})
    monkeypatch.setattr(atomic_files.os, "replace", full)
    with pytest.raises(VhDrakeError, match="No space left on device"):
        write_json(path, {"a": 2})
    assert json.loads(path.read_text()) == {"a": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_can_not_be_made_is_told_by_its_path(tmp_path):
    (tmp_path / "file").write_text("old")
    path = tmp_path / "file" / "result.json"
    with pytest.raises(VhDrakeError) as error:
        write_json(path, {})
    assert str(path) in str(error.value)
    assert not isinstance(error.value, BadInput)
    assert (tmp_path / "file").read_text() == "old"
