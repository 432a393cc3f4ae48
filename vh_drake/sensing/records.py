"""Tables of numbers inside point files, read only after their size was checked."""

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.types import Array


def check_count(count: int, max_points: int) -> None:
    """Refuses a number of points that is none or too many.

    Raises:
        BadInput: the count lies outside 1 ... max_points.
    """
    if not 1 <= count <= max_points:
        raise BadInput(f"it announces {count} points; 1 to {max_points} can be read")


def binary_columns(data: bytes, count: int, dtype: np.dtype, columns: list[str]) -> Array:
    """Columns (count, k) of packed records.

    Raises:
        BadInput: the data end before the last record.
    """
    needed = count * dtype.itemsize
    if len(data) < needed:
        raise BadInput(
            f"it announces {count} points of {dtype.itemsize} bytes and holds "
            f"{len(data)} of {needed} bytes; it is truncated or damaged"
        )
    records = np.frombuffer(data, dtype, count)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.stack([records[name].astype(float) for name in columns], axis=1)


def text_columns(data: bytes, count: int, width: int, columns: list[int]) -> Array:
    """Columns (count, k) of lines of numbers that are separated by blanks.

    Args:
        data: the text; what follows the last line is ignored.
        count: number of lines.
        width: numbers a line.
        columns: which of them.

    Raises:
        BadInput: fewer lines, a short line, or something that is no number.
    """
    lines = data.split(b"\n", count)[:count]
    values = np.empty((count, len(columns)))
    if len(lines) < count:
        raise BadInput(f"it announces {count} points and has {len(lines)} lines; it is truncated")
    for i, line in enumerate(lines):
        words = line.split(None, width)
        if len(words) < width:
            raise BadInput(f"point {i} has {len(words)} values instead of {width}: {line[:60]!r}")
        try:
            values[i] = [float(words[column]) for column in columns]
        except ValueError as error:
            raise BadInput(f"point {i} holds something that is no number: {line[:60]!r}") from error
    return values
