"""Which objects a metric learns from, and which it must never see."""

from pathlib import Path

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.learning.shapes import shape_mesh, shape_names
from vh_drake.objects.folders import read_folder
from vh_drake.objects.library import library_names, library_object
from vh_drake.objects.loading import load_object

# The kinds of table 4.6, with which the whole pipeline is judged.
VALIDATION_KINDS = frozenset(
    {
        "aluminum_profile",
        "cutter",
        "hammer",
        "multimeter",
        "pliers",
        "power_drill",
        "screw_box",
        "spray_bottle",
    }
)
TEST_SPLIT = "test"
_SHAPE_PREFIX = "shape_"


def training_objects(folder: Path | None, *, shapes: int, library: bool = True) -> list[str]:
    """Names of objects to learn from, sorted.

    Args:
        folder: meshes of the user's own; what its objects.csv calls "test" is left out.
        shapes: how many drawn shapes come along.
        library: whether the embedded objects come along, less those of table 4.6.

    Raises:
        BadInput: nothing is left, or the folder is unusable.
    """
    names = shape_names(shapes)
    if library:
        names += [name for name in library_names() if name not in VALIDATION_KINDS]
    if folder is not None:
        entries = read_folder(folder).items()
        names += [name for name, entry in entries if entry.split != TEST_SPLIT]
    if not names:
        raise BadInput("no object to learn from; give a folder, shapes, or the library")
    return sorted(set(names))


def object_mesh(name: str, folder: Path | None) -> TriMesh:
    """The watertight mesh of an object: of the folder first, then drawn or embedded.

    Raises:
        BadInput: no such object, or its file is unusable.
    """
    if folder is not None and name in read_folder(folder):
        return load_object(name, folder=folder).mesh
    if name.startswith(_SHAPE_PREFIX):
        return shape_mesh(name)
    return library_object(name).mesh
