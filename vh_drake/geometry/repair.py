"""Making any triangle soup a watertight solid, and saying what was done to it."""

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask, TriMesh, from_trimesh
from vh_drake.geometry.remesh import remesh
from vh_drake.types import Array, IntArray

_MERGE_SHARE = 1e-6  # of the diagonal: vertices nearer than this are one
_SPECK_SHARE = 0.02  # of the diagonal: loose parts smaller than this are noise
_CAP_AREA_SHARE = 0.25  # of the surface: openings beyond are meant to be open
_MAX_ALIGNED = 50_000  # triangles: aligning more takes minutes
_MAX_HOLES = 2_000  # more are no holes but a mesh in shreds
_REMESH_NODES = 100  # along the longest side


@dataclass(frozen=True, eq=False)
class Repaired:
    """A watertight mesh of positive volume, and what it took."""

    mesh: TriMesh
    report: tuple[str, ...]  # sentences, empty where nothing had to be done


def repair_mesh(mesh: TriMesh) -> Repaired:
    """Make a mesh watertight and consistently wound, keeping its concavities.

    Vertices are merged, degenerate and duplicate faces and specks dropped, windings aligned,
    holes capped. What stays open then is remeshed on a grid: a sheet with wide openings as
    a thin shell, anything else as a solid where it wraps a volume.

    Raises:
        BadInput: there is no surface left to work with.
    """
    report: list[str] = []
    mesh = _clean(mesh, report)
    mesh = _drop_specks(mesh, report)
    mesh = _align_winding(mesh, report)
    mesh = _cap_holes(mesh, report)
    if not mesh.is_watertight:
        mesh, sentence = remesh(mesh, nodes=_REMESH_NODES, as_sheet=_is_sheet(mesh))
        report.append(sentence)
    mesh = _turn_outward(mesh, report)
    if not mesh.volume > 0:
        raise BadInput("the mesh encloses no volume; give it a thickness")
    return Repaired(mesh, tuple(report))


def _clean(mesh: TriMesh, report: list[str]) -> TriMesh:
    """Merge vertices, drop degenerate and duplicate faces."""
    diagonal = mesh.with_faces(np.arange(len(mesh.faces))).diagonal if len(mesh.faces) else 0.0
    if not diagonal > 0:
        raise BadInput("all triangles lie in one point; there is no surface to work with")
    keys = np.round(mesh.vertices / (diagonal * _MERGE_SHARE)).astype(np.int64)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[mesh.faces]
    if len(first) < len(mesh.vertices):
        report.append(f"Merged {len(mesh.vertices) - len(first)} duplicate vertices.")
    keep = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    _, unique = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    keep &= np.isin(np.arange(len(faces)), unique)
    if not keep.all():
        report.append(f"Dropped {np.count_nonzero(~keep)} degenerate or duplicate triangles.")
    if not keep.any():
        raise BadInput("every triangle is degenerate; there is no surface to work with")
    return TriMesh(mesh.vertices[first], faces).with_faces(keep)


def face_components(mesh: TriMesh) -> IntArray:
    """Number of the connected part that each face belongs to, (f,)."""
    n = len(mesh.vertices)
    edges = mesh.directed_edges
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    of_vertex = connected_components(graph, directed=False)[1]
    labels: IntArray = np.unique(of_vertex[mesh.faces[:, 0]], return_inverse=True)[1]
    return labels.astype(np.int64)


def _drop_specks(mesh: TriMesh, report: list[str]) -> TriMesh:
    """Drop loose parts too small to matter."""
    labels = face_components(mesh)
    low, high = component_boxes(mesh, labels)
    small = np.linalg.norm(high - low, axis=1) < _SPECK_SHARE * mesh.diagonal
    if small.all() or not small.any():
        return mesh
    report.append(f"Dropped {np.count_nonzero(small)} loose specks.")
    return mesh.with_faces(~small[labels])


def component_boxes(mesh: TriMesh, labels: IntArray) -> tuple[Array, Array]:
    """Least and largest corner of each connected part, (c, 3) each [m]."""
    low = np.full((labels.max() + 1, 3), np.inf)
    high = -low
    np.minimum.at(low, labels, mesh.triangles.min(axis=1))
    np.maximum.at(high, labels, mesh.triangles.max(axis=1))
    return low, high


def _align_winding(mesh: TriMesh, report: list[str]) -> TriMesh:
    """Let neighbouring faces agree on which side is out."""
    keys = mesh.directed_edges @ np.array([len(mesh.vertices), 1])
    if len(np.unique(keys)) == len(keys):
        return mesh
    if len(mesh.faces) > _MAX_ALIGNED:
        raise BadInput(
            f"{len(mesh.faces)} triangles are wound inconsistently, more than {_MAX_ALIGNED} "
            "that can be mended; decimate the mesh"
        )
    aligned = mesh.to_trimesh()
    trimesh.repair.fix_winding(aligned)
    report.append("Aligned triangles that were wound against their neighbours.")
    return from_trimesh(aligned)


def _cap_holes(mesh: TriMesh, report: list[str]) -> TriMesh:
    """Close holes by a fan around their centre, except wide openings."""
    loops = boundary_loops(mesh.boundary_edges)
    if len(loops) > _MAX_HOLES:
        return mesh
    vertices, caps, size = [mesh.vertices], [], len(mesh.vertices)
    largest = _CAP_AREA_SHARE * mesh.areas.sum()
    for loop in loops:
        rim = mesh.vertices[loop]
        center = rim.mean(axis=0)
        spokes = rim - center
        area = np.linalg.norm(np.cross(spokes, np.roll(spokes, -1, axis=0)), axis=1).sum() / 2
        if area <= largest:
            vertices.append(center[None])
            caps.append(np.stack([np.roll(loop, -1), loop, np.full_like(loop, size)], axis=1))
            size += 1
    if not caps:
        return mesh
    report.append(f"Closed {len(caps)} hole{'s' if len(caps) > 1 else ''}.")
    return TriMesh(np.vstack(vertices), np.vstack([mesh.faces, *caps]))


def _is_sheet(mesh: TriMesh) -> bool:
    """Whether what is open has clean rims, which then are wide openings and no damage."""
    loops = boundary_loops(mesh.boundary_edges)
    rims = np.concatenate([np.zeros(0, np.int64), *loops])
    return len(rims) == len(mesh.boundary_edges) == len(np.unique(rims))


def boundary_loops(edges: IntArray) -> list[IntArray]:
    """Closed chains of directed edges (e, 2); what does not close is left out."""
    following: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        following.setdefault(start, []).append(end)
    loops = []
    for start in sorted(following):
        while following[start]:
            loop = _walk(following, start)
            if loop:
                loops.append(np.array(loop, dtype=np.int64))
    return loops


def _walk(following: dict[int, list[int]], start: int) -> list[int]:
    """Follow edges, using them up, until the start is met again; empty at a dead end."""
    loop, vertex = [], start
    while following.get(vertex):
        loop.append(vertex)
        vertex = following[vertex].pop()
        if vertex == start:
            return loop
    return []


def _turn_outward(mesh: TriMesh, report: list[str]) -> TriMesh:
    """Flip closed parts that are inside out, except cavities within another part."""
    labels = face_components(mesh)
    cones = np.einsum("fi,fi->f", mesh.triangles[:, 0] - mesh.bounds[0], mesh.area_vectors)
    inverted = np.bincount(labels, weights=cones) < 0
    inverted &= ~_are_cavities(mesh, labels)
    if not inverted.any():
        return mesh
    report.append("Turned the surface outward, it was inside out.")
    flip = inverted[labels]
    return TriMesh(mesh.vertices, np.where(flip[:, None], mesh.faces[:, ::-1], mesh.faces))


def _are_cavities(mesh: TriMesh, labels: IntArray) -> Mask:
    """Which parts lie, by their boxes, strictly within the largest part, (c,)."""
    low, high = component_boxes(mesh, labels)
    largest = np.linalg.norm(high - low, axis=1).argmax()
    within: Mask = ((low > low[largest]) & (high < high[largest])).all(axis=1)
    return within
