import os
import stat

import pytest

from vh_drake import atomic_files
from vh_drake.atomic_files import write_bytes
from vh_drake.errors import BadInput, VhDrakeError


def test_a_file_is_written_with_its_folders_and_replaced(tmp_path):
    path = tmp_path / "a" / "b" / "c.bin"
    write_bytes(path, b"old")
    write_bytes(path, b"new")
    assert path.read_bytes() == b"new"
    assert [file.name for file in path.parent.iterdir()] == ["c.bin"]


def test_others_may_read_it_as_the_umask_says(tmp_path):
    before = os.umask(0o022)
    try:
        write_bytes(tmp_path / "a", b"")
        assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o644
        assert os.umask(0o022) == 0o022
    finally:
        os.umask(before)


def test_a_full_disk_leaves_the_old_file_and_no_rest(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    path = tmp_path / "a"
    write_bytes(path, b"old")
    monkeypatch.setattr(atomic_files.os, "replace", full)
    with pytest.raises(VhDrakeError, match="No space left on device") as error:
        write_bytes(path, b"new")
    assert not isinstance(error.value, BadInput)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_is_a_file_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(VhDrakeError, match="can't write"):
        write_bytes(tmp_path / "file" / "a", b"")
