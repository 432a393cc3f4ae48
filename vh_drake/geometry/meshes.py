"""The triangle mesh that every part of the project shares."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import trimesh
from numpy.typing import NDArray

from vh_drake.types import Array, IntArray

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class TriMesh:
    """Triangles with counter-clockwise vertices as seen from outside."""

    vertices: Array  # (v, 3) [m]
    faces: IntArray  # (f, 3) indices into vertices

    @cached_property
    def triangles(self) -> Array:
        """Corners of each face, (f, 3, 3) [m]."""
        return self.vertices[self.faces]

    @cached_property
    def area_vectors(self) -> Array:
        """Outward normal of each face, as long as the face's area, (f, 3) [m²]."""
        a, b, c = self.triangles.swapaxes(0, 1)
        vectors: Array = np.cross(b - a, c - a) / 2
        return vectors

    @cached_property
    def areas(self) -> Array:
        """Area of each face, (f,) [m²]."""
        areas: Array = np.linalg.norm(self.area_vectors, axis=1)
        return areas

    @cached_property
    def face_normals(self) -> Array:
        """Outward unit normal of each face, (f, 3); zero where a face has no area."""
        lengths = self.areas[:, None]
        normals: Array = np.divide(
            self.area_vectors, lengths, out=np.zeros_like(self.area_vectors), where=lengths > 0
        )
        return normals

    @cached_property
    def volume(self) -> float:
        """Enclosed volume by the divergence theorem [m³]; negative when turned inside out."""
        return float(np.einsum("fi,fi->", self.triangles[:, 0], self.area_vectors) / 3)

    @cached_property
    def bounds(self) -> Array:
        """Least and largest coordinates, (2, 3) [m]."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def extents(self) -> Array:
        """Sides of the axis-aligned bounding box, (3,) [m]."""
        extents: Array = self.bounds[1] - self.bounds[0]
        return extents

    @property
    def diagonal(self) -> float:
        """Diagonal of the axis-aligned bounding box [m]."""
        return float(np.linalg.norm(self.extents))

    @cached_property
    def is_watertight(self) -> bool:
        """Whether each directed edge meets its opposite: closed and consistently wound."""
        return len(self.faces) > 0 and len(self.boundary_edges) == 0

    @cached_property
    def boundary_edges(self) -> IntArray:
        """Directed edges that lack their opposite, (e, 2) vertex indices."""
        edges = self.directed_edges
        n = np.int64(len(self.vertices))
        keys, counts = np.unique(edges[:, 0] * n + edges[:, 1], return_counts=True)
        reversed_keys = (keys % n) * n + keys // n
        places = np.minimum(np.searchsorted(keys, reversed_keys), len(keys) - 1)
        opposite = np.where(keys[places] == reversed_keys, counts[places], 0)
        open_keys = np.repeat(keys, np.maximum(counts - opposite, 0))
        return np.stack([open_keys // n, open_keys % n], axis=1)

    @cached_property
    def directed_edges(self) -> IntArray:
        """Edges in the order of their faces, (3 f, 2) vertex indices."""
        return self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)

    @cached_property
    def convex_hull(self) -> "TriMesh":
        """The convex hull, watertight."""
        return from_trimesh(self.to_trimesh().convex_hull)

    def scaled(self, factor: float) -> "TriMesh":
        """The mesh with every coordinate multiplied."""
        return TriMesh(self.vertices * factor, self.faces)

    def flipped(self) -> "TriMesh":
        """The mesh turned inside out."""
        return TriMesh(self.vertices, self.faces[:, ::-1])

    def transformed(self, X: Array) -> "TriMesh":
        """The mesh moved by a homogeneous transform (4, 4)."""
        return TriMesh(self.vertices @ X[:3, :3].T + X[:3, 3], self.faces)

    def with_faces(self, keep: Mask | IntArray) -> "TriMesh":
        """Some of the faces, by mask or index, without vertices that nothing uses."""
        faces = self.faces[keep]
        used, inverse = np.unique(faces, return_inverse=True)
        return TriMesh(self.vertices[used], inverse.reshape(-1, 3).astype(np.int64))

    def to_trimesh(self) -> trimesh.Trimesh:
        """The same mesh as a trimesh object, unprocessed."""
        return trimesh.Trimesh(self.vertices, self.faces, process=False)


def from_trimesh(mesh: trimesh.Trimesh) -> TriMesh:
    """Copy a trimesh object."""
    return TriMesh(np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64))


def concatenate(meshes: Sequence[TriMesh]) -> TriMesh:
    """Put meshes side by side in one, without merging anything."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
    return TriMesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces))
