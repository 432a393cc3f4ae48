"""Reading a user's file with a limit."""

from pathlib import Path

from vh_drake.errors import BadInput


def read_bytes(path: str | Path, max_bytes: int) -> bytes:
    """The content of a file that is neither missing, empty nor larger than allowed.

    Raises:
        BadInput: no such file, no regular file, no right to read it, empty, or too large.
    """
    path = Path(path)
    try:
        if not path.is_file():
            raise BadInput(f"no file at {path}")
        size = path.stat().st_size
        if size == 0:
            raise BadInput(f"{path} is empty")
        if size > max_bytes:
            raise BadInput(f"{path} has {size} bytes, more than the {max_bytes} allowed")
        with path.open("rb") as stream:
            return stream.read(max_bytes)
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name.
        raise BadInput(f"{path} cannot be read: {error}") from error


def read_text(path: str | Path, max_bytes: int) -> str:
    """The content of a UTF-8 text file.

    Raises:
        BadInput: as in `read_bytes`, or it is no UTF-8.
    """
    try:
        return read_bytes(path, max_bytes).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInput(f"{path} is no UTF-8 text: {error}") from error
