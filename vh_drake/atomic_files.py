"""Files that are written whole or not at all."""

import os
import tempfile
from pathlib import Path

from vh_drake.errors import VhDrakeError


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file atomically, making its folder.

    Raises:
        VhDrakeError: the folder can't be written or the disk is full; an old file stays.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.chmod(temporary, 0o666 & ~_umask())
            os.replace(temporary, path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise VhDrakeError(f"can't write {path}: {error.strerror or error}") from error


def _umask() -> int:
    """What a new file may not permit; asking for it means setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
