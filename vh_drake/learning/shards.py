"""Scenes on disk: one Parquet row a scene, compact, without voxel grids.

Poses and points are kept in single precision; what is computed from a row after a round trip is
what was computed from it before.
"""

import dataclasses as dc
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask
from vh_drake.types import Array, Candidates, ContactSet, IntArray, ObjectView, Plane

FORMAT = "vh_drake scenes 1"
_MAX_BYTES = 512 * 2**20
_FLOATS = pa.list_(pa.float32())
_COUNTS = pa.list_(pa.int16())
_DOUBLES = pa.list_(pa.float64())
_NAMES = pa.dictionary(pa.int8(), pa.string())

SCHEMA = pa.schema(
    [
        ("scene", pa.int64()),
        ("object", pa.string()),
        ("seed", pa.int64()),
        ("table", _DOUBLES),  # normal and offset
        ("p_WCamera", _DOUBLES),
        ("p_WO", _FLOATS),
        ("n_WO", _FLOATS),
        ("p_WC", _FLOATS),
        ("n_WC", _FLOATS),
        ("X_WH", _FLOATS),  # 12 a candidate, row by row
        ("motion", pa.list_(_NAMES)),
        ("planner", pa.list_(_NAMES)),
        ("label_rate", _FLOATS),  # on the true object
        ("label_error", _FLOATS),  # its standard error
        ("label_samples", _COUNTS),
        ("estimate_rate", _FLOATS),  # the same on the estimate
        ("estimate_samples", _COUNTS),
        ("nominal", pa.list_(pa.bool_())),  # closed on the estimate, undisturbed
    ],
    metadata={"format": FORMAT},
)


@dc.dataclass(frozen=True, eq=False)
class LabelledScene:
    """One scene with n rated candidates."""

    scene: int
    object: str
    seed: int
    view: ObjectView
    contacts: ContactSet
    candidates: Candidates
    label_rate: Array  # (n,) force-closure rate on the true object
    label_error: Array  # (n,) its standard error
    label_samples: IntArray  # (n,)
    estimate_rate: Array  # (n,) on the estimate
    estimate_samples: IntArray  # (n,)
    nominal: Mask  # (n,) closed, undisturbed on the estimate


def shard_bytes(scenes: Sequence[LabelledScene]) -> bytes:
    """A Parquet file of scenes; the same bytes for the same scenes."""
    table = pa.Table.from_pylist([_row(scene) for scene in scenes], schema=SCHEMA)
    sink = io.BytesIO()
    pq.write_table(table, sink, compression="zstd", use_dictionary=["object"])
    return sink.getvalue()


def read_shard(path: Path) -> list[LabelledScene]:
    """The scenes of a file.

    Raises:
        BadInput: it is missing, truncated, too large or no shard; the message names the remedy.
    """
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise BadInput(f"{path}: larger than {_MAX_BYTES} bytes; this is no shard")
        table = pq.read_table(path)
        if not table.schema.equals(SCHEMA):
            raise BadInput(f"{path}: its columns are not those of {FORMAT!r}; generate it anew")
        scenes = [_scene(row) for row in table.to_pylist()]
    except (OSError, pa.ArrowException, ValueError, IndexError, TypeError) as error:
        raise BadInput(
            f"{path} cannot be read: {error}; delete it and run `vh-drake dataset generate` again"
        ) from error
    return scenes


def _row(scene: LabelledScene) -> dict[str, Any]:
    view, contacts, candidates = scene.view, scene.contacts, scene.candidates
    return {
        "scene": scene.scene,
        "object": scene.object,
        "seed": scene.seed,
        "table": [*view.table.normal, view.table.offset],
        "p_WCamera": view.p_WCamera,
        "p_WO": _flat(view.p_WO),
        "n_WO": _flat(view.n_WO),
        "p_WC": _flat(contacts.p_WC),
        "n_WC": _flat(contacts.n_WC),
        "X_WH": _flat(candidates.X_WH[:, :3]),
        "motion": list(candidates.motion),
        "planner": list(candidates.planner),
        "label_rate": _flat(scene.label_rate),
        "label_error": _flat(scene.label_error),
        "label_samples": scene.label_samples,
        "estimate_rate": _flat(scene.estimate_rate),
        "estimate_samples": scene.estimate_samples,
        "nominal": scene.nominal.astype(bool),
    }


def _flat(values: Array) -> np.ndarray:
    return np.asarray(values, np.float32).ravel()


def _scene(row: dict[str, Any]) -> LabelledScene:
    table = np.array(row["table"])
    view = ObjectView(
        _points(row["p_WO"]),
        _points(row["n_WO"]),
        Plane(table[:3], float(table[3])),
        np.array(row["p_WCamera"]),
    )
    X_WH = np.tile(np.eye(4), (len(row["motion"]), 1, 1))
    X_WH[:, :3] = np.array(row["X_WH"], float).reshape(-1, 3, 4)
    return LabelledScene(
        scene=row["scene"],
        object=row["object"],
        seed=row["seed"],
        view=view,
        contacts=ContactSet(_points(row["p_WC"]), _points(row["n_WC"])),
        candidates=Candidates(X_WH, tuple(row["motion"]), tuple(row["planner"])),
        label_rate=np.array(row["label_rate"], float),
        label_error=np.array(row["label_error"], float),
        label_samples=np.array(row["label_samples"], np.int64),
        estimate_rate=np.array(row["estimate_rate"], float),
        estimate_samples=np.array(row["estimate_samples"], np.int64),
        nominal=np.array(row["nominal"], bool),
    )


def _points(values: list[float]) -> Array:
    return np.array(values, float).reshape(-1, 3)
