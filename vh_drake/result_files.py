"""Results on disk: written whole or not at all."""

import json
from collections.abc import Mapping
from pathlib import Path

from vh_drake.atomic_files import write_bytes


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 file atomically, making its folder.

    Raises:
        VhDrakeError: the folder can't be written or the disk is full; an old file stays.
    """
    write_bytes(path, text.encode())


def write_json(path: Path, content: Mapping[str, object]) -> None:
    """Write an object as JSON, see `write_text`."""
    write_text(path, json.dumps(content, indent=2) + "\n")
