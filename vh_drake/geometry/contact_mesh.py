"""Coarse watertight meshes for contact, with the deviation from the original measured."""

from dataclasses import dataclass

from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import remesh_solid, simplify
from vh_drake.geometry.sampling import sample_surface
from vh_drake.geometry.signed_distance import distance_to_surface

_SAMPLES = 1000
_REMESH_NODES = 64
_AGGRESSIVENESS = (5.0, 2.0, 1.0)


@dataclass(frozen=True, eq=False)
class ContactMesh:
    """A coarse watertight mesh and how far it lies from the fine one."""

    mesh: TriMesh
    deviation_m: float  # largest distance between the surfaces, sampled both ways


def coarsen(mesh: TriMesh, *, triangles: int = 300) -> ContactMesh:
    """Simplify a watertight mesh, concavities kept.

    Edges are collapsed by quadric errors. Should that tear the surface, the collapse is
    repeated more carefully, and at last on a remeshed surface.
    """
    fine = mesh
    for aggressiveness in _AGGRESSIVENESS:
        coarse = simplify(mesh, triangles, aggressiveness=aggressiveness)
        if _is_sound(coarse, mesh):
            return ContactMesh(coarse, surface_deviation(fine, coarse))
    rebuilt, _ = remesh_solid(mesh, nodes=_REMESH_NODES)
    coarse = simplify(rebuilt, triangles)
    if not _is_sound(coarse, rebuilt):
        coarse = mesh.convex_hull
    return ContactMesh(coarse, surface_deviation(fine, coarse))


def surface_deviation(first: TriMesh, second: TriMesh) -> float:
    """Largest distance [m] of samples of either surface, vertices included, from the other."""
    deviation = 0.0
    for source, target in ((first, second), (second, first)):
        samples, _ = sample_surface(source, _SAMPLES, seed=0)
        for points in (samples, source.vertices[:: max(1, len(source.vertices) // _SAMPLES)]):
            deviation = max(deviation, float(distance_to_surface(target, points).max()))
    return deviation


def _is_sound(coarse: TriMesh, fine: TriMesh) -> bool:
    """Whether a simplified mesh is still closed and of like volume."""
    return coarse.is_watertight and 0.7 * fine.volume < coarse.volume < 1.3 * fine.volume
