"""Vertices of PLY files (Turk 1994): ascii, little and big endian."""

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.sensing.records import binary_columns, check_count, text_columns
from vh_drake.types import Array

_MAX_HEADER = 65_536  # [byte]
_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def read_ply_points(data: bytes, max_points: int) -> Array:
    """Vertices (n, 3) of a point cloud or mesh; all else in the file is ignored.

    Raises:
        BadInput: no PLY file, damaged, truncated, or too many vertices.
    """
    header, body = _split(data)
    order = _format(header)
    count, properties = _vertex_element(header)
    check_count(count, max_points)
    names = [name for name, _ in properties]
    if not {"x", "y", "z"} <= set(names) or len(set(names)) < len(names):
        raise BadInput(f"its vertices need x, y and z, each once, and have {', '.join(names)}")
    if not order:
        return text_columns(body, count, len(names), [names.index(axis) for axis in "xyz"])
    dtype = np.dtype([(name, order + kind) for name, kind in properties])
    return binary_columns(body, count, dtype, ["x", "y", "z"])


def _split(data: bytes) -> tuple[list[list[str]], bytes]:
    """Words of the header's lines, and what follows the header."""
    if not data.startswith(b"ply"):
        raise BadInput("it does not begin with 'ply' and so is no PLY file")
    end = data.find(b"end_header", 0, _MAX_HEADER)
    line_end = data.find(b"\n", end)
    if end < 0 or line_end < 0:
        raise BadInput("its PLY header has no end; the file is truncated or damaged")
    lines = data[:end].decode("ascii", "replace").replace("\r", "\n").split("\n")
    return [line.split() for line in lines if line.strip()], data[line_end + 1 :]


def _format(header: list[list[str]]) -> str:
    for words in header:
        if words[0] == "format" and len(words) > 1 and words[1] in _ORDERS:
            return _ORDERS[words[1]]
    raise BadInput(f"its PLY header names no format among {', '.join(_ORDERS)}")


def _vertex_element(header: list[list[str]]) -> tuple[int, list[tuple[str, str]]]:
    """Number of vertices, and name and type of their properties."""
    starts = [i for i, words in enumerate(header) if words[0] == "element"]
    if not starts or header[starts[0]][1:2] != ["vertex"]:
        raise BadInput("its first PLY element is not 'vertex'; save the vertices first")
    words = header[starts[0]]
    if len(words) != 3 or not words[2].isascii() or not words[2].isdigit() or len(words[2]) > 12:
        raise BadInput(f"its PLY header has no number of vertices: {' '.join(words)[:60]!r}")
    end = starts[1] if len(starts) > 1 else len(header)
    rows = [row for row in header[starts[0] + 1 : end] if row[0] == "property"]
    if any(len(row) != 3 or row[1] not in _TYPES for row in rows):
        raise BadInput("its vertices have a property of unknown type; x, y, z as float will do")
    return int(words[2]), [(row[2], _TYPES[row[1]]) for row in rows]
