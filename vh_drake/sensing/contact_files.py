"""Contacts and table planes that a user brings as files."""

import csv
import dataclasses as dc
import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.errors import BadInput
from vh_drake.sensing.file_bytes import read_text
from vh_drake.types import Array, ContactSet, Plane
from vh_drake.yaml_files import load_typed

MAX_BYTES = 2**20
MAX_CONTACTS = 1000
_COLUMNS = ("x", "y", "z", "nx", "ny", "nz")


@dc.dataclass
class TableFile:
    """The table plane as a file holds it: the points x with normal · x = offset [m]."""

    normal: list[float] = dc.field(default_factory=list)
    offset: float = 0.0


def load_contacts(path: str | Path) -> ContactSet:
    """Reads touched places: x, y, z [m] and the outward normal nx, ny, nz, in W.

    CSV: six columns a line, with or without a header line of these names. JSON: a list (or
    an object with the list under "contacts") of objects with these keys or of six numbers.

    Returns:
        The contacts, normals made unit, repeated ones dropped.

    Raises:
        BadInput: missing, empty, malformed, too many, not finite, a normal of length zero, or
            two contacts at one place whose normals oppose each other.
    """
    path = Path(path)
    parsers = {".csv": _csv_rows, ".json": _json_rows}
    parser = parsers.get(path.suffix.lower())
    if parser is None:
        raise BadInput(f"{path}: contacts are one of .csv, .json, not {path.suffix!r}")
    text = read_text(path, MAX_BYTES)
    try:
        return _contacts(_numbers(parser(text)))
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error


def load_table(path: str | Path) -> Plane:
    """Reads a table plane, the points x with normal · x = offset [m], from JSON or YAML.

    Returns:
        The plane with a unit normal that points up.

    Raises:
        BadInput: missing, malformed, not finite, or a normal that leans more than 45 degrees.
    """
    if Path(path).suffix.lower() not in (".json", ".yaml", ".yml"):
        raise BadInput(f"{path}: a table is one of .json, .yaml, .yml")
    table = load_typed(TableFile, path)
    return _plane(np.array(table.normal, dtype=float), float(table.offset), str(path))


def _plane(normal: Array, offset: float, name: str) -> Plane:
    with np.errstate(over="ignore", invalid="ignore"):
        length = float(np.linalg.norm(normal))
    if normal.shape != (3,) or not np.isfinite([length, offset]).all() or length < 1e-9:
        raise BadInput(f"{name}: the normal needs 3 finite values that are not all zero")
    length *= 1.0 if normal[2] >= 0.0 else -1.0
    if normal[2] / length < np.cos(np.pi / 4):
        raise BadInput(f"{name}: the normal {normal} is not vertical; z of W must point up")
    return Plane(normal / length, offset / length)


def _csv_rows(text: str) -> list[list[Any]]:
    try:
        rows: list[list[Any]] = [row for row in csv.reader(text.splitlines()) if row]
    except csv.Error as error:
        raise BadInput(f"it is no CSV: {error}") from error
    if rows and [word.strip().lower() for word in rows[0]] == list(_COLUMNS):
        return rows[1:]
    return rows


def _json_rows(text: str) -> list[list[Any]]:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadInput(f"it is no JSON: {error}") from error
    rows = data.get("contacts") if isinstance(data, dict) else data
    if not isinstance(rows, list):
        raise BadInput("a list of contacts is needed, alone or under the key 'contacts'")
    return [_json_row(row) for row in rows]


def _json_row(row: Any) -> list[Any]:
    if isinstance(row, dict) and set(row) == set(_COLUMNS):
        return [row[name] for name in _COLUMNS]
    if isinstance(row, list):
        return row
    raise BadInput(f"a contact has the keys {', '.join(_COLUMNS)}, or is a list of 6 numbers")


def _numbers(rows: list[list[Any]]) -> Array:
    if not 1 <= len(rows) <= MAX_CONTACTS:
        raise BadInput(f"it holds {len(rows)} contacts; 1 to {MAX_CONTACTS} can be read")
    for i, row in enumerate(rows):
        if len(row) != len(_COLUMNS):
            raise BadInput(f"contact {i} has {len(row)} values; {', '.join(_COLUMNS)} are needed")
    try:
        values = np.array([[float(value) for value in row] for row in rows])
    except (TypeError, ValueError, OverflowError) as error:
        raise BadInput(f"a contact holds something that is no number: {error}") from error
    wrong = np.flatnonzero(~np.isfinite(values).all(axis=1) | (np.abs(values) > 1e6).any(axis=1))
    if len(wrong):
        raise BadInput(f"contact {wrong[0]} has NaN, infinite or huge values: {values[wrong[0]]}")
    return values


def _contacts(values: Array) -> ContactSet:
    p_WC, normals = values[:, :3], values[:, 3:]
    lengths = np.linalg.norm(normals, axis=1)
    if lengths.min() < 1e-6:
        raise BadInput(f"the normal of contact {int(lengths.argmin())} has no length")
    n_WC = normals / lengths[:, None]
    keep = np.ones(len(p_WC), bool)
    for i, j in sorted(cKDTree(p_WC).query_pairs(1e-3)):
        if n_WC[i] @ n_WC[j] < 0.0:
            raise BadInput(
                f"contacts {i} and {j} lie within 1 mm and their normals oppose each other; "
                "one of them is wrong"
            )
        keep[j] &= np.linalg.norm(p_WC[i] - p_WC[j]) > 1e-4
    return ContactSet(p_WC[keep], n_WC[keep])
