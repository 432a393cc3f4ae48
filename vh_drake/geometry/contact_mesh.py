"""Coarse watertight meshes for contact, with the deviation from the original measured."""

from collections.abc import Iterator
from dataclasses import dataclass

from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import remesh, simplify
from vh_drake.geometry.sampling import sample_surface
from vh_drake.geometry.signed_distance import distance_to_surface

_SAMPLES = 1000
_REMESH_NODES = 100
_AGGRESSIVENESS = (5.0, 3.0, 7.0)
_GOOD_DEVIATION_M = 0.002
_SLACK = 1.5  # times the wanted number of triangles is still coarse


@dataclass(frozen=True, eq=False)
class ContactMesh:
    """A coarse watertight mesh and how far it lies from the fine one."""

    mesh: TriMesh
    deviation_m: float  # largest distance between the surfaces, sampled both ways


def coarsen(mesh: TriMesh, *, triangles: int = 300) -> ContactMesh:
    """Simplify a watertight mesh, concavities kept.

    Edges are collapsed by quadric errors, with several settings and at last on a remeshed
    surface. The first result within 2 mm of the original is taken, else the nearest one.
    """
    best = None
    for coarse in _candidates(mesh, triangles):
        if not _is_sound(coarse, mesh, triangles):
            continue
        result = ContactMesh(coarse, surface_deviation(mesh, coarse))
        if result.deviation_m <= _GOOD_DEVIATION_M:
            return result
        if best is None or result.deviation_m < best.deviation_m:
            best = result
    if best is None:
        hull = simplify(mesh.convex_hull, triangles)
        best = ContactMesh(hull, surface_deviation(mesh, hull))
    return best


def surface_deviation(first: TriMesh, second: TriMesh) -> float:
    """Largest distance [m] of samples of either surface, vertices included, from the other."""
    deviation = 0.0
    for source, target in ((first, second), (second, first)):
        samples, _ = sample_surface(source, _SAMPLES, seed=0)
        for points in (samples, source.vertices[:: max(1, len(source.vertices) // _SAMPLES)]):
            deviation = max(deviation, float(distance_to_surface(target, points).max()))
    return deviation


def _candidates(mesh: TriMesh, triangles: int) -> Iterator[TriMesh]:
    """Coarse meshes, the likeliest first."""
    for aggressiveness in _AGGRESSIVENESS:
        yield simplify(mesh, triangles, aggressiveness=aggressiveness)
    rebuilt, _ = remesh(mesh, nodes=_REMESH_NODES)
    yield simplify(rebuilt, triangles)


def _is_sound(coarse: TriMesh, fine: TriMesh, triangles: int) -> bool:
    """Whether a simplified mesh is closed, coarse, and of like volume."""
    return (
        coarse.is_watertight
        and len(coarse.faces) <= max(_SLACK * triangles, 4)
        and 0.7 * fine.volume < coarse.volume < 1.3 * fine.volume
    )
