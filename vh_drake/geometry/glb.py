"""Triangles of a binary glTF 2.0 file: positions, indices and node poses, nothing else.

Textures, animations, skins and external buffers are not opened, so that a file from
anywhere can neither reach outside itself nor unpack to more than it weighs.
"""

import json
import struct
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh, concatenate
from vh_drake.types import Array

_JSON_CHUNK = 0x4E4F534A
_BINARY_CHUNK = 0x004E4942
_TRIANGLES = 4
_DTYPES: dict[int, np.dtype[Any]] = {
    5121: np.dtype("<u1"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
}
_FLOAT: np.dtype[Any] = np.dtype("<f4")
_MAX_DEPTH = 64
_MAX_NODES = 10_000


def read_glb(data: bytes, *, max_triangles: int) -> TriMesh:
    """Triangles of all scenes, in the file's units.

    Raises:
        BadInput: no glTF 2.0, external or compressed buffers, no triangles, or too many.
    """
    document, buffer = _chunks(data)
    if any("uri" in entry for entry in document.get("buffers", [])):
        raise BadInput("a buffer lies outside the file; export it with buffers embedded")
    reader = _Reader(document, buffer, max_triangles)
    children = {child for node in reader.nodes for child in node.get("children", [])}
    for root in range(len(reader.nodes)):
        if root not in children:
            reader.visit(root, np.eye(4), 0)
    if not reader.parts:
        raise BadInput("no triangles in it; a mesh is needed")
    return concatenate(reader.parts)


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    """The JSON document and the binary buffer."""
    if len(data) < 20:
        raise BadInput("truncated glTF file")
    magic, version, _ = struct.unpack_from("<4sII", data)
    length, kind = struct.unpack_from("<II", data, 12)
    if magic != b"glTF" or version != 2 or kind != _JSON_CHUNK:
        raise BadInput("no binary glTF 2.0 file")
    document = json.loads(data[20 : 20 + length])
    if not isinstance(document, dict):
        raise BadInput("its JSON part is no object")
    start = 20 + length
    if len(data) < start + 8:
        return document, b""
    size, kind = struct.unpack_from("<II", data, start)
    if kind != _BINARY_CHUNK:
        raise BadInput("its second part is no binary buffer")
    return document, data[start + 8 : start + 8 + size]


class _Reader:
    """Walks the node tree and gathers triangles, up to a limit."""

    def __init__(self, document: dict[str, Any], buffer: bytes, max_triangles: int) -> None:
        self.nodes: list[dict[str, Any]] = document.get("nodes", [])
        self.parts: list[TriMesh] = []
        self._document = document
        self._buffer = buffer
        self._triangles_left = max_triangles
        self._visits_left = _MAX_NODES

    def visit(self, index: int, X_WParent: Array, depth: int) -> None:
        """Gather a node's triangles and those of its children."""
        self._visits_left -= 1
        if depth > _MAX_DEPTH or self._visits_left < 0:
            raise BadInput(f"its node tree is deeper than {_MAX_DEPTH} or over {_MAX_NODES} nodes")
        node = self.nodes[index]
        X_WN = X_WParent @ _node_pose(node)
        if "mesh" in node:
            for primitive in self._document["meshes"][node["mesh"]]["primitives"]:
                self._gather(primitive, X_WN)
        for child in node.get("children", []):
            self.visit(child, X_WN, depth + 1)

    def _gather(self, primitive: dict[str, Any], X_WN: Array) -> None:
        """Add the triangles of one primitive."""
        if primitive.get("mode", _TRIANGLES) != _TRIANGLES:
            return
        vertices = self._accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
        if "indices" in primitive:
            faces = self._accessor(primitive["indices"]).astype(np.int64).reshape(-1, 3)
        else:
            faces = np.arange(len(vertices), dtype=np.int64).reshape(-1, 3)
        self._triangles_left -= len(faces)
        if self._triangles_left < 0:
            raise BadInput("too many triangles; decimate it")
        if len(faces) and faces.max() >= len(vertices):
            raise BadInput("a triangle names a vertex that is not there; export it again")
        self.parts.append(TriMesh(vertices, faces).transformed(X_WN))

    def _accessor(self, index: int) -> Array:
        """Values of an accessor: (n, 3) positions or (n,) indices."""
        accessor = self._document["accessors"][index]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise BadInput("sparse or compressed geometry is not read; export it uncompressed")
        view = self._document["bufferViews"][accessor["bufferView"]]
        is_vector = accessor["type"] == "VEC3"
        dtype = _FLOAT if is_vector else _DTYPES[accessor["componentType"]]
        width = dtype.itemsize * (3 if is_vector else 1)
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride, count = view.get("byteStride", width), accessor["count"]
        if min(start, count - 1, stride - width) < 0:
            raise BadInput("a buffer with negative sizes; export it again")
        if start + stride * (count - 1) + width > len(self._buffer):
            raise BadInput("truncated: a buffer ends early")
        values: Array = np.ndarray(
            (count, 3) if is_vector else (count,),
            dtype,
            self._buffer,
            start,
            (stride, dtype.itemsize) if is_vector else (stride,),
        )
        return values


def _node_pose(node: dict[str, Any]) -> Array:
    """A node's transform in its parent, (4, 4)."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    X = np.eye(4)
    rotation = Rotation.from_quat(node.get("rotation", (0.0, 0.0, 0.0, 1.0))).as_matrix()
    X[:3, :3] = rotation * np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
    X[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return X
