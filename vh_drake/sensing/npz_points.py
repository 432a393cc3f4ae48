"""Points of NumPy archives, without pickle and without trust in what they announce."""

import io
import math
import zipfile
import zlib

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.types import Array

_POINTS = ("points", "p_WC", "xyz", "arr_0")
_CAMERA = ("camera", "p_WCamera")
# What zipfile, zlib and NumPy raise at damaged archives.
_DAMAGES = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    KeyError,
    OSError,
    OverflowError,
    RuntimeError,
    SyntaxError,
    ValueError,
)


def read_npz_points(data: bytes, max_points: int) -> tuple[Array, Array]:
    """Points (n, 3) and optical centre (3,), zero where the file has none.

    The points are an array named `points`, `p_WC`, `xyz` or `arr_0`, of shape (n, 3) or more
    columns or (h, w, 3); the optical centre is named `camera` or `p_WCamera`.

    Raises:
        BadInput: no NPZ file, damaged, without points, or too many.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = {name.removesuffix(".npy"): name for name in archive.namelist()}
            key = next((name for name in _POINTS if name in names), None)
            if key is None:
                raise BadInput(
                    f"it has no array named {', '.join(_POINTS)} but {sorted(names)[:8]}"
                )
            points = _member(archive, names[key], max_points * 64)
            camera = next((name for name in _CAMERA if name in names), None)
            centre = _member(archive, names[camera], 4096) if camera else np.zeros(3)
    except BadInput:
        raise
    except _DAMAGES as error:
        raise BadInput(f"it is a damaged NPZ file: {error}") from error
    return _shaped(points, max_points), _centre(centre)


def _member(archive: zipfile.ZipFile, name: str, max_bytes: int) -> Array:
    """One array; the size that its header announces must be the one that it has."""
    if archive.getinfo(name).file_size > max_bytes:
        raise BadInput(f"{name} unpacks to {archive.getinfo(name).file_size} bytes; too large")
    with archive.open(name) as stream:
        raw = io.BytesIO(stream.read(max_bytes))
    version = np.lib.format.read_magic(raw)
    read = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    if version not in read:
        raise BadInput(f"{name} has the unknown format version {version}")
    shape, fortran, dtype = read[version](raw)
    body = raw.read()
    if dtype.kind not in "fiu" or math.prod(shape) * dtype.itemsize != len(body):
        raise BadInput(f"{name} announces {shape} of {dtype} and holds {len(body)} bytes")
    flat = np.frombuffer(body, dtype).astype(float)
    return flat.reshape(shape, order="F" if fortran else "C")


def _shaped(points: Array, max_points: int) -> Array:
    if points.ndim < 2 or points.shape[-1] < 3:
        raise BadInput(f"its points have the shape {points.shape}; (n, 3) is needed")
    rows = points.reshape(-1, points.shape[-1])[:, :3]
    if not 1 <= len(rows) <= max_points:
        raise BadInput(f"it holds {len(rows)} points; 1 to {max_points} can be read")
    return rows


def _centre(centre: Array) -> Array:
    if centre.size != 3 or not np.isfinite(centre).all():
        raise BadInput(f"its optical centre has the shape {centre.shape}; 3 finite values needed")
    return centre.reshape(3)
