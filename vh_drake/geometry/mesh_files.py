"""Reading triangle meshes from files that nobody vouches for.

Sizes are checked before anything is parsed, and a file is read on its own: no material,
texture or buffer that it names is opened.
"""

import io
import logging
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import trimesh

from vh_drake.errors import BadInput
from vh_drake.geometry.glb import read_glb
from vh_drake.geometry.meshes import TriMesh

SUFFIXES = (".obj", ".ply", ".stl", ".glb")
MAX_BYTES = 50_000_000
MAX_TRIANGLES = 1_000_000

_PLY_ELEMENT = re.compile(rb"^element\s+(\S+)\s+(\S+)\s*$", re.MULTILINE)
_OBJ_FACE = re.compile(rb"^[ \t]*f[ \t]", re.MULTILINE)
_OBJ_LINE_LIMIT = 20_000


def load_mesh(path: Path | str) -> TriMesh:
    """Read an obj, ply, stl or glb file as it is, unrepaired.

    Raises:
        BadInput: the file is missing, empty, of another format, over MAX_BYTES or
            MAX_TRIANGLES, damaged, a point cloud, or holds NaN or infinite coordinates.
    """
    path = Path(path)
    data = _read_bytes(path)
    try:
        mesh = _PARSERS[path.suffix.lower()](data)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error
    except (Exception, RecursionError) as error:  # a parser fails in any way on damaged bytes
        raise BadInput(
            f"{path}: damaged {path.suffix.lower()} file ({type(error).__name__}); export it again"
        ) from error
    _check_content(path, mesh)
    return mesh


def _read_bytes(path: Path) -> bytes:
    """Contents of a file of a known format, at most MAX_BYTES long."""
    if not path.is_file():
        raise BadInput(f"{path}: no such file")
    if path.suffix.lower() not in SUFFIXES:
        raise BadInput(
            f"{path}: format {path.suffix!r} is not read; convert it to {', '.join(SUFFIXES)}"
        )
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise BadInput(f"{path}: {size / 1e6:.0f} MB, over the limit of 50 MB; decimate it")
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise BadInput(f"{path}: can't be read ({error.strerror})") from error
    if not data.strip():
        raise BadInput(f"{path}: the file is empty")
    return data


def _check_content(path: Path, mesh: TriMesh) -> None:
    """Refuse what is no usable surface."""
    if len(mesh.faces) > MAX_TRIANGLES:
        raise BadInput(f"{path}: {len(mesh.faces)} triangles, over {MAX_TRIANGLES}; decimate it")
    if len(mesh.faces) == 0:
        raise BadInput(
            f"{path}: a point cloud ({len(mesh.vertices)} points, no triangles); "
            "a mesh is needed, so reconstruct its surface first"
        )
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise BadInput(f"{path}: a triangle names a vertex that is not there; export it again")
    bad = int(np.count_nonzero(~np.isfinite(mesh.vertices).all(axis=1)))
    if bad:
        raise BadInput(f"{path}: {bad} vertices are NaN or infinite; clean the mesh first")
    if np.abs(mesh.vertices).max() > 1e9:
        raise BadInput(f"{path}: coordinates beyond 1e9; the file is damaged or its unit is wrong")


@contextmanager
def _silence() -> Iterator[None]:
    """Keep a parser's own complaints about damaged files off the terminal."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(level)


def _parse_with_trimesh(data: bytes, file_type: str) -> TriMesh:
    """Let trimesh parse bytes, without any access to other files."""
    options = {"skip_materials": True} if file_type == "obj" else {}
    with _silence():
        loaded = trimesh.load(io.BytesIO(data), file_type=file_type, process=False, **options)
    if isinstance(loaded, trimesh.PointCloud):
        return TriMesh(np.asarray(loaded.vertices, float), np.zeros((0, 3), np.int64))
    if isinstance(loaded, trimesh.Scene):
        loaded = loaded.to_mesh()
    return TriMesh(
        np.array(loaded.vertices, dtype=np.float64).reshape(-1, 3),
        np.array(loaded.faces, dtype=np.int64).reshape(-1, 3),
    )


def _parse_ply(data: bytes) -> TriMesh:
    """Parse a PLY file whose header promises no more than the file can hold."""
    header, separator, _ = data.partition(b"end_header")
    if not data.startswith(b"ply") or not separator:
        raise BadInput("no PLY header; export it again")
    counts = {name: int(count) for name, count in _PLY_ELEMENT.findall(header)}
    if any(count < 0 or count > len(data) for count in counts.values()):
        raise BadInput(f"the header promises {max(counts.values())} elements, the file is shorter")
    faces = counts.get(b"face", 0)
    if faces > MAX_TRIANGLES:
        raise BadInput(f"{faces} triangles, over {MAX_TRIANGLES}; decimate it")
    if faces == 0:
        raise BadInput(
            f"a point cloud ({counts.get(b'vertex', 0)} points, no triangles); "
            "a mesh is needed, so reconstruct its surface first"
        )
    return _parse_with_trimesh(data, "ply")


def _parse_stl(data: bytes) -> TriMesh:
    """Parse an STL file, binary where its length fits its count, else ASCII."""
    promised = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * promised:
        if promised > MAX_TRIANGLES:
            raise BadInput(f"{promised} triangles, over {MAX_TRIANGLES}; decimate it")
        return _parse_with_trimesh(data, "stl")
    if b"facet" not in data or b"\0" in data:
        raise BadInput(f"truncated: binary STL of {promised} triangles in {len(data)} bytes")
    return _parse_with_trimesh(data, "stl_ascii")


def _parse_obj(data: bytes) -> TriMesh:
    """Parse a Wavefront file, geometry only."""
    faces = len(_OBJ_FACE.findall(data))
    if faces > MAX_TRIANGLES:
        raise BadInput(f"{faces} faces, over {MAX_TRIANGLES}; decimate it")
    if faces == 0:
        raise BadInput(
            "a point cloud or no mesh at all (no line starts with 'f'); "
            "a mesh is needed, so reconstruct its surface first"
        )
    if max(map(len, data.splitlines())) > _OBJ_LINE_LIMIT:
        raise BadInput(f"a line is longer than {_OBJ_LINE_LIMIT} characters; export it again")
    return _parse_with_trimesh(data, "obj")


_PARSERS: dict[str, Callable[[bytes], TriMesh]] = {
    ".obj": _parse_obj,
    ".ply": _parse_ply,
    ".stl": _parse_stl,
    ".glb": lambda data: read_glb(data, max_triangles=MAX_TRIANGLES),
}
