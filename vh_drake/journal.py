"""Results that survive a kill: one line of JSON a task, appended as soon as it is done."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vh_drake.atomic_files import write_bytes
from vh_drake.errors import BadInput, VhDrakeError

_MAX_BYTES = 2_000_000_000


class Journal:
    """A file of finished tasks.

    The first line holds the settings. A line that a kill cut short is dropped, so that the
    task is done again.

    Args:
        path: of the file; made, with its folder, where it is missing.
        settings: all that the results depend on, as JSON holds it.

    Raises:
        BadInput: the file belongs to other settings, or is no journal.
        VhDrakeError: the file can't be written.
    """

    def __init__(self, path: Path, settings: Mapping[str, Any]) -> None:
        self._path = path
        header = json.dumps({"settings": settings}, sort_keys=True)
        lines = self._whole_lines()
        if lines and lines[0] != header:
            raise BadInput(
                f"{path} holds results of other settings; choose another --out, or delete it"
            )
        self.results: dict[str, Any] = {}
        for line in lines[1:]:
            entry = _parsed(path, line)
            self.results[entry["key"]] = entry["result"]
        write_bytes(path, "".join(f"{line}\n" for line in lines or [header]).encode())

    def add(self, key: str, result: Any) -> None:
        """Append a result; on disk when this returns.

        Raises:
            VhDrakeError: the disk is full or the file can't be written; what was there stays.
        """
        line = json.dumps({"key": key, "result": result}) + "\n"
        try:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(line)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise VhDrakeError(f"can't write {self._path}: {error.strerror or error}") from error
        self.results[key] = json.loads(line)["result"]

    def _whole_lines(self) -> list[str]:
        """The lines of the file that end; none where there is no file."""
        if not self._path.is_file():
            return []
        if self._path.stat().st_size > _MAX_BYTES:
            raise BadInput(f"{self._path}: larger than 2 GB; this is no journal")
        try:
            text = self._path.read_bytes().decode()
        except UnicodeDecodeError as error:
            raise BadInput(
                f"{self._path} is no journal of vh_drake; choose another --out"
            ) from error
        return text.split("\n")[:-1]


def _parsed(path: Path, line: str) -> dict[str, Any]:
    try:
        entry = json.loads(line)
        return {"key": entry["key"], "result": entry["result"]}
    except (json.JSONDecodeError, TypeError, KeyError) as error:
        raise BadInput(f"{path} is damaged; delete it, or choose another --out") from error
