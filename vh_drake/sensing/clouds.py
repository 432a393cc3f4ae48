"""A user's own point cloud: PLY, PCD, NPZ, or the vertices of an OBJ mesh.

The parsers are our own because native loaders crash on damaged files: every count is held
against the file's size before memory is taken.
"""

import dataclasses as dc
from pathlib import Path

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.sensing.file_bytes import read_bytes
from vh_drake.sensing.npz_points import read_npz_points
from vh_drake.sensing.pcd_points import read_pcd_points
from vh_drake.sensing.ply_points import read_ply_points
from vh_drake.types import Array, Cloud

MAX_BYTES = 256 * 2**20
MAX_POINTS = 4_000_000
_EXTENT_M = 1000.0  # points farther from the origin are not of this table


@dc.dataclass(frozen=True, eq=False)
class LoadedCloud:
    """A cloud and what was dropped from its file."""

    cloud: Cloud
    dropped: int  # points with NaN or infinite coordinates


def load_cloud(
    path: str | Path,
    p_WCamera: Array | None = None,
    *,
    max_bytes: int = MAX_BYTES,
    max_points: int = MAX_POINTS,
) -> LoadedCloud:
    """Reads a point cloud in metres, expressed in W.

    Args:
        path: a .ply, .pcd, .npz or .obj file; a mesh gives its vertices.
        p_WCamera: (3,) optical centre [m]; else the file's own (PCD's VIEWPOINT, `camera` in
            NPZ), else the origin.
        max_bytes: larger files are refused.
        max_points: larger clouds are refused.

    Returns:
        The finite points and the number of the others.

    Raises:
        BadInput: missing, empty, damaged, truncated or too large, an unknown suffix, fewer
            than half of the points finite, or coordinates that cannot be metres.
    """
    path = Path(path)
    readers = {".ply": _ply, ".pcd": read_pcd_points, ".npz": read_npz_points, ".obj": _obj}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise BadInput(f"{path}: a cloud is one of {', '.join(readers)}, not {path.suffix!r}")
    try:
        points, centre = reader(read_bytes(path, max_bytes), max_points)
        points, dropped = _finite(points)
    except BadInput as error:
        raise BadInput(str(error) if str(path) in str(error) else f"{path}: {error}") from error
    centre = centre if p_WCamera is None else np.asarray(p_WCamera, dtype=float)
    return LoadedCloud(Cloud(points, centre), dropped)


def _ply(data: bytes, max_points: int) -> tuple[Array, Array]:
    return read_ply_points(data, max_points), np.zeros(3)


def _obj(data: bytes, max_points: int) -> tuple[Array, Array]:
    rows = [line.split()[1:4] for line in data.splitlines() if line.startswith((b"v ", b"v\t"))]
    if not 1 <= len(rows) <= max_points:
        raise BadInput(f"it has {len(rows)} vertices; 1 to {max_points} can be read")
    try:
        return np.array([[float(x), float(y), float(z)] for x, y, z in rows]), np.zeros(3)
    except ValueError as error:
        raise BadInput(f"a vertex is not three numbers: {error}") from error


def _finite(points: Array) -> tuple[Array, int]:
    finite = np.isfinite(points).all(axis=1)
    dropped = int(np.count_nonzero(~finite))
    if 2 * dropped > len(points):
        raise BadInput(f"{dropped} of {len(points)} points are NaN or infinite; too few are left")
    points = points[finite]
    extent = float(np.abs(points).max())
    if extent > _EXTENT_M:
        raise BadInput(
            f"its points reach {extent:.4g} m from the origin; are they in millimetres? "
            "Scale them to metres"
        )
    return points, dropped
