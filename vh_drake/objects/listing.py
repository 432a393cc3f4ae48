"""Tables of the objects that can be grasped, one row an object."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vh_drake.objects.folders import read_folder
from vh_drake.objects.library import library_names, library_object


@dataclass(frozen=True)
class ObjectRow:
    """What is known of an object before it is put on the table."""

    name: str
    mass_g: float | None  # None where nobody says; it is then computed from the volume
    size_mm: str = ""  # Along x, y and z of its own frame; empty for files, which stay unread.
    split: str = ""
    file: str = ""


def library_rows() -> list[ObjectRow]:
    """The embedded objects, sorted by name."""
    rows = []
    for name in library_names():
        model = library_object(name)
        size_mm = np.ptp(model.mesh.vertices, axis=0) * 1000
        text = " x ".join(f"{length:.0f}" for length in size_mm)
        rows.append(ObjectRow(name, round(model.mass_kg * 1000, 1), text))
    return rows


def folder_rows(folder: Path) -> list[ObjectRow]:
    """The objects of a folder, sorted by name; their meshes are not read.

    Raises:
        BadInput: no such folder, no mesh in it, or an unusable objects.csv.
    """
    return [
        ObjectRow(
            entry.name,
            None if entry.mass_kg is None else round(entry.mass_kg * 1000, 1),
            split=entry.split,
            file=str(entry.path.relative_to(folder)),
        )
        for _, entry in sorted(read_folder(folder).items())
    ]
