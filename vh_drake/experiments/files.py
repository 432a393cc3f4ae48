"""Results on disk: written whole or not at all."""

import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from vh_drake.errors import VhDrakeError


def write_text(path: Path, text: str) -> None:
    """Write a file atomically, making its folder.

    Raises:
        VhDrakeError: the folder can't be written or the disk is full; an old file stays.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(text)
            os.replace(temporary, path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise VhDrakeError(f"can't write {path}: {error.strerror or error}") from error


def write_json(path: Path, content: Mapping[str, object]) -> None:
    """Write an object as JSON, see `write_text`."""
    write_text(path, json.dumps(content, indent=2) + "\n")
