"""Sets of objects that a user brings along in a folder."""

import csv
from dataclasses import dataclass
from pathlib import Path

from vh_drake.errors import BadInput
from vh_drake.geometry.mesh_files import SUFFIXES

_YCB_MESHES = (
    "google_16k/textured.obj",
    "google_16k/nontextured.ply",
    "google_16k/nontextured.stl",
    "google_64k/textured.obj",
    "google_64k/nontextured.ply",
    "poisson/textured.obj",
    "poisson/nontextured.ply",
    "tsdf/textured.obj",
    "tsdf/nontextured.ply",
)
_TABLE = "objects.csv"
_MAX_TABLE_BYTES = 1_000_000


@dataclass(frozen=True)
class FolderEntry:
    """One object of a folder."""

    name: str
    path: Path
    mass_kg: float | None = None  # where objects.csv gives it
    split: str = ""  # "train", "test" or whatever objects.csv says
    lift: str = ""  # "core", "hard" or "no": whether a hand can be asked to lift it


def list_objects(folder: Path) -> list[str]:
    """Names of the objects in a folder, sorted."""
    return sorted(read_folder(folder))


def read_folder(folder: Path) -> dict[str, FolderEntry]:
    """Objects of a folder by name.

    Each mesh file directly in the folder is an object, and each sub-folder that holds a mesh
    in the layout of the YCB download (`<name>/google_16k/textured.obj`) or just one mesh
    file. `objects.csv` with columns `name` and optionally `mass_kg`, `split` and `lift`
    tells masses [kg], splits, and what a hand can be asked to lift.

    Raises:
        BadInput: no such folder, no mesh in it, or an unusable objects.csv.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such folder of objects")
    paths: dict[str, Path] = {}
    for child in sorted(folder.iterdir()):
        path = _mesh_in(child) if child.is_dir() else child
        if path is not None and path.suffix.lower() in SUFFIXES and path.is_file():
            paths.setdefault(child.name if child.is_dir() else child.stem, path)
    if not paths:
        raise BadInput(f"{folder}: no mesh in it ({', '.join(SUFFIXES)}, or the YCB layout)")
    rows = _read_table(folder / _TABLE)
    return {name: _entry(name, path, rows.get(name, {})) for name, path in paths.items()}


def _mesh_in(folder: Path) -> Path | None:
    """The mesh of a sub-folder, if it has one."""
    for relative in _YCB_MESHES:
        if (folder / relative).is_file():
            return folder / relative
    meshes = [path for path in sorted(folder.iterdir()) if path.suffix.lower() in SUFFIXES]
    return meshes[0] if len(meshes) == 1 else None


def _read_table(path: Path) -> dict[str, dict[str, str]]:
    """Rows of objects.csv by name; none where there is no such file."""
    if not path.is_file():
        return {}
    if path.stat().st_size > _MAX_TABLE_BYTES:
        raise BadInput(f"{path}: larger than 1 MB; this is no table of objects")
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
    except (csv.Error, UnicodeDecodeError, OSError) as error:
        raise BadInput(f"{path}: no readable CSV file ({error})") from error
    if rows and "name" not in rows[0]:
        raise BadInput(f"{path}: has no column 'name'")
    return {row["name"]: row for row in rows if row["name"]}


def _entry(name: str, path: Path, row: dict[str, str]) -> FolderEntry:
    """An object with what the table says of it."""
    text = (row.get("mass_kg") or "").strip()
    try:
        mass = float(text) if text else None
    except ValueError as error:
        raise BadInput(f"objects.csv: mass_kg of {name} is {text!r}, not a number") from error
    if mass is not None and not 0 < mass <= 100:
        raise BadInput(f"objects.csv: mass_kg of {name} is {text}, not between 0 and 100")
    split, lift = ((row.get(column) or "").strip() for column in ("split", "lift"))
    return FolderEntry(name, path, mass, split, lift)
