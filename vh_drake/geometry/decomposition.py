"""Convex pieces of a mesh, for contact models that know only convex shapes."""

import hashlib
import io
import json
import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.geometry import coacd_process
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import simplify
from vh_drake.types import Array

_CONVEX_SHARE = 0.95  # of the hull's volume: such a mesh is convex enough
_INPUT_TRIANGLES = 800
_HULL_TRIANGLES = 400
_OPTIONS = {
    "threshold": 0.06,
    "max_convex_hull": 16,
    "preprocess_resolution": 40,
    "resolution": 500,
    "mcts_nodes": 10,
    "mcts_iterations": 20,
    "mcts_max_depth": 2,
    "decimate": True,
    "max_ch_vertex": 48,
}


def cache_folder() -> Path:
    """Where results that cost time are kept, `$XDG_CACHE_HOME/vh_drake` or its default."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vh_drake"


def convex_pieces(mesh: TriMesh, *, seed: int = 0, cache: Path | None = None) -> tuple[Array, ...]:
    """Vertices of at most 16 convex pieces that cover a watertight mesh, (n_i, 3) each [m].

    A mesh that fills its hull by 95 % is one piece, its hull. Others are cut by CoACD
    (Wei et al. 2022), and the result is kept in the cache.

    Args:
        mesh: Watertight.
        seed: Of the search for cuts.
        cache: Folder of the cache, default `cache_folder() / "convex"`.
    """
    hull = mesh.convex_hull
    if mesh.volume > _CONVEX_SHARE * hull.volume:
        return (simplify(hull, _HULL_TRIANGLES).vertices,)
    path = (cache or cache_folder() / "convex") / f"{_content_key(mesh, seed)}.npz"
    pieces = _read(path)
    if pieces is None:
        pieces = _decompose(mesh, seed)
        _write(path, pieces)
    return pieces


def _decompose(mesh: TriMesh, seed: int) -> tuple[Array, ...]:
    """Run CoACD; its own repair of the mesh is asked for where it fails without."""
    coarse = simplify(mesh, _INPUT_TRIANGLES)
    for mode in ("auto", "on"):
        pieces = _in_a_process(coarse, {**_OPTIONS, "preprocess_mode": mode, "seed": seed})
        if pieces:
            return pieces
    warnings.warn("the mesh can't be cut into convex pieces; its hull is taken", stacklevel=3)
    return (simplify(mesh.convex_hull, _HULL_TRIANGLES).vertices,)


def _in_a_process(mesh: TriMesh, options: Mapping[str, Any]) -> tuple[Array, ...]:
    """CoACD's pieces; none where it fails, since some meshes make it end its process."""
    given = io.BytesIO()
    np.savez(given, vertices=mesh.vertices, faces=mesh.faces)
    command = [sys.executable, coacd_process.__file__, json.dumps(dict(options))]
    done = subprocess.run(command, input=given.getvalue(), capture_output=True, check=False)
    if done.returncode != 0:
        return ()
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as archive:
        return tuple(archive[f"arr_{i}"] for i in range(len(archive.files)))


def _content_key(mesh: TriMesh, seed: int) -> str:
    """Hash of everything that the result depends on."""
    digest = hashlib.sha256(mesh.vertices.tobytes())
    digest.update(mesh.faces.tobytes())
    digest.update(repr((sorted(_OPTIONS.items()), _INPUT_TRIANGLES, seed)).encode())
    return digest.hexdigest()[:32]


def _read(path: Path) -> tuple[Array, ...] | None:
    """Pieces from the cache; none where they are missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            pieces = tuple(archive[f"arr_{i}"] for i in range(len(archive.files)))
    except Exception:  # a cache that can't be read is computed anew, whatever is wrong with it
        return None
    if not pieces or any(piece.ndim != 2 or piece.shape[1] != 3 for piece in pieces):
        return None
    return pieces


def _write(path: Path, pieces: tuple[Array, ...]) -> None:
    """Keep pieces in the cache, whole or not at all; a folder that can't be written is let be."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False) as file:
            np.savez(file, *pieces)
        os.replace(file.name, path)
    except OSError:
        return
