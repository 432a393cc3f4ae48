"""Points of PCD files (Point Cloud Library, version 0.7): ascii and binary."""

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.sensing.records import binary_columns, check_count, text_columns
from vh_drake.types import Array

_MAX_HEADER = 16_384  # [byte]
_KINDS = {
    f"{letter}{size}": f"<{kind}{size}"
    for letter, kind, sizes in (("F", "f", "48"), ("I", "i", "1248"), ("U", "u", "1248"))
    for size in sizes
}


def read_pcd_points(data: bytes, max_points: int) -> tuple[Array, Array]:
    """Points (n, 3) and the viewpoint (3,) of a PCD file.

    Raises:
        BadInput: no PCD file, damaged, truncated, compressed, or too many points.
    """
    header, body = _split(data)
    fields = header.get("FIELDS", [])
    counts = _integers(header, "COUNT", ["1"] * len(fields))
    sizes, kinds = header.get("SIZE", []), header.get("TYPE", [])
    if not len(fields) == len(counts) == len(sizes) == len(kinds):
        raise BadInput("FIELDS, SIZE, TYPE and COUNT of its PCD header differ in length")
    if any(fields.count(axis) != 1 for axis in "xyz"):
        raise BadInput(f"its points need x, y and z, each once, and have {' '.join(fields)}")
    points = _integers(header, "POINTS", ["0"])[0]
    check_count(points, max_points)
    encoding = header.get("DATA", [""])[0]
    if encoding == "ascii":
        columns = [sum(counts[: fields.index(axis)]) for axis in "xyz"]
        p_W = text_columns(body, points, sum(counts), columns)
    elif encoding == "binary":
        dtype = _record(
            fields, [kind + size for kind, size in zip(kinds, sizes, strict=True)], counts
        )
        axes = [f"{fields.index(axis)}" for axis in "xyz"]
        p_W = binary_columns(body, points, dtype, axes)
    else:
        raise BadInput(f"its PCD data are {encoding!r}; save them as ascii or binary")
    return p_W, _viewpoint(header)


def _split(data: bytes) -> tuple[dict[str, list[str]], bytes]:
    """Words of each header line by its first word, and what follows the header."""
    start = data.find(b"DATA", 0, _MAX_HEADER)
    end = data.find(b"\n", start)
    if start < 0 or end < 0:
        raise BadInput("its PCD header has no DATA line; it is truncated or no PCD file")
    lines = data[:end].decode("ascii", "replace").splitlines()
    rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    return {row[0]: row[1:] or [""] for row in rows}, data[end + 1 :]


def _integers(header: dict[str, list[str]], name: str, default: list[str]) -> list[int]:
    words = header.get(name, default)
    if not all(word.isascii() and word.isdigit() and len(word) <= 9 for word in words):
        raise BadInput(f"{name} of its PCD header is no list of numbers: {' '.join(words)[:60]!r}")
    if name == "COUNT" and not all(1 <= int(word) <= 4096 for word in words):
        raise BadInput("COUNT of its PCD header lies outside 1 to 4096")
    return [int(word) for word in words]


def _record(fields: list[str], kinds: list[str], counts: list[int]) -> np.dtype:
    """A record whose field i is named by its number, since PCD repeats the name '_'."""
    unknown = [kind for kind in kinds if kind not in _KINDS]
    if unknown:
        raise BadInput(f"its PCD fields have the unknown type and size {unknown[0]!r}")
    if any(counts[fields.index(axis)] != 1 for axis in "xyz"):
        raise BadInput("x, y and z of its points must have COUNT 1")
    return np.dtype(
        [(f"{i}", _KINDS[kind], (count,)) if count > 1 else (f"{i}", _KINDS[kind])
         for i, (kind, count) in enumerate(zip(kinds, counts, strict=True))]
    )  # fmt: skip


def _viewpoint(header: dict[str, list[str]]) -> Array:
    try:
        p_WCamera = np.array([float(word) for word in header["VIEWPOINT"][:3]])
    except (KeyError, ValueError):
        return np.zeros(3)
    return p_WCamera if p_WCamera.shape == (3,) and np.isfinite(p_WCamera).all() else np.zeros(3)
