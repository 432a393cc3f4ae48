"""One way in for every object: a name of the library, a mesh file, or a name in a folder."""

from pathlib import Path

import numpy as np

from vh_drake.errors import BadInput, UnknownName
from vh_drake.geometry.mesh_files import SUFFIXES, load_mesh
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import simplify
from vh_drake.geometry.repair import repair_mesh
from vh_drake.objects.folders import FolderEntry, read_folder
from vh_drake.objects.library import library_names, library_object
from vh_drake.objects.model import ObjectModel, make_object

MAX_SIDE_M = 0.5
MIN_SIDE_M = 0.005
_MAX_TRIANGLES = 20_000  # of the mesh that simulation, cameras and judges use
_ASSUMED_DENSITY = 400.0  # [kg/m³], of packaged goods and hollow plastics
_ASSUMED_MASS_RANGE = (0.01, 1.0)  # [kg]


def load_object(
    spec: str | Path,
    *,
    mass_kg: float | None = None,
    scale: float = 1.0,
    folder: Path | None = None,
) -> ObjectModel:
    """Load an object and make it fit for simulation.

    Args:
        spec: A name of the library, a path of a mesh file, or a name within `folder`.
        mass_kg: Overrides the mass that is known for the object.
        scale: Multiplies all coordinates, 0.001 for a file in millimetres.
        folder: A set of objects, see `vh_drake.objects.folders`.

    Raises:
        BadInput: the file, mass, scale or size is unusable.
        UnknownName: no such object in the library or folder.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise BadInput(f"scale {scale:g} is not positive; 0.001 turns millimetres into metres")
    if mass_kg is not None and not (np.isfinite(mass_kg) and 0 < mass_kg <= 100):
        raise BadInput(f"mass {mass_kg:g} kg is not between 0 and 100 kg")
    if folder is not None:
        entries = read_folder(folder)
        if str(spec) in entries:
            return _load_file(entries[str(spec)], mass_kg, scale)
        raise UnknownName(f"object in {folder}", str(spec), list(entries))
    if str(spec) in library_names():
        return _load_from_library(str(spec), mass_kg, scale)
    path = Path(spec)
    if path.suffix.lower() in SUFFIXES or (path.suffix and path.is_file()):
        return _load_file(FolderEntry(path.stem, path), mass_kg, scale)
    if path.is_dir():
        raise BadInput(f"{path} is a folder; pass it as --objects and name one of its objects")
    raise UnknownName("object", str(spec), library_names())


def _load_from_library(name: str, mass_kg: float | None, scale: float) -> ObjectModel:
    """An object of the library, with the user's mass and scale where given."""
    known = library_object(name)
    if mass_kg is None and scale == 1.0:
        return known
    source = known.mass_source if mass_kg is None else "given"
    primitive = known.primitive if scale == 1.0 else None
    mesh = known.mesh.scaled(scale)
    _check_size(name, mesh)
    return make_object(
        name,
        mesh,
        known.mass_kg if mass_kg is None else mass_kg,
        mass_source=source,
        primitive=primitive,
        report=() if scale == 1.0 else (f"Scaled by {scale:g}.",),
    )


def _load_file(entry: FolderEntry, mass_kg: float | None, scale: float) -> ObjectModel:
    """Read, scale, check, repair and weigh a mesh file."""
    mesh = load_mesh(entry.path).scaled(scale)
    used = mesh.with_faces(np.arange(len(mesh.faces)))
    _check_size(str(entry.path), used)
    try:
        repaired = repair_mesh(used)
    except BadInput as error:
        raise BadInput(f"{entry.path}: {error}") from error
    lighter, sentences = _lighten(repaired.mesh)
    mass, source = _mass(entry, lighter, mass_kg)
    scaled = () if scale == 1.0 else (f"Scaled by {scale:g}.",)
    report = (*scaled, *repaired.report, *sentences)
    return make_object(entry.name, lighter, mass, mass_source=source, report=report)


def _lighten(mesh: TriMesh) -> tuple[TriMesh, tuple[str, ...]]:
    """Simplify a heavy mesh where it stays closed, and say so."""
    lighter = simplify(mesh, _MAX_TRIANGLES)
    if lighter is mesh or not lighter.is_watertight or lighter.volume <= 0:
        return mesh, ()
    return lighter, (f"Simplified from {len(mesh.faces)} to {len(lighter.faces)} triangles.",)


def _check_size(name: str, mesh: TriMesh) -> None:
    """Refuse what no hand can hold, and guess a wrong unit."""
    largest = float(mesh.extents.max())
    if largest > MAX_SIDE_M:
        remedy = f"the limit is {MAX_SIDE_M:g} m; take a smaller object or pass --scale"
        if largest * 1e-3 <= MAX_SIDE_M and largest * 1e-3 >= MIN_SIDE_M:
            remedy = "it looks like millimetres; pass --scale 0.001"
        raise BadInput(f"{name}: {largest:.3g} m long, too large; {remedy}")
    if largest < MIN_SIDE_M:
        raise BadInput(
            f"{name}: {largest * 1e3:.3g} mm long, too small (at least {MIN_SIDE_M * 1e3:g} mm); "
            "if its unit is not metres, pass --scale"
        )


def _mass(entry: FolderEntry, mesh: TriMesh, mass_kg: float | None) -> tuple[float, str]:
    """Mass [kg] and where it comes from."""
    if mass_kg is not None:
        return mass_kg, "given"
    if entry.mass_kg is not None:
        return entry.mass_kg, "objects.csv"
    mass = float(np.clip(_ASSUMED_DENSITY * mesh.volume, *_ASSUMED_MASS_RANGE))
    return mass, f"assumed from its volume at {_ASSUMED_DENSITY:g} kg/m³; pass --mass to set it"
