"""Surfaces from contacts with and without normals, and how far they are from the truth."""

import math
from dataclasses import dataclass, field

import numpy as np

from vh_drake.geometry.closest_points import closest_faces, triangle_tree
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.gpis.contact_surface import ContactNoise, ContactSurface
from vh_drake.gpis.edges import EdgeSettings, edge_contacts
from vh_drake.gpis.following import Sheet, follow_surface
from vh_drake.gpis.inside_outside import InsideOutside, inside_outside_observations
from vh_drake.gpis.kernels import Kernel, ThinPlate
from vh_drake.gpis.posterior import fit
from vh_drake.types import Array

_POINTS = 20_000  # on either surface


@dataclass(frozen=True)
class Reconstruction:
    """How surfaces are estimated from contacts."""

    kernel: Kernel = field(default_factory=lambda: ThinPlate(0.5, 0.5 / math.sqrt(6.0)))
    noise: ContactNoise = field(default_factory=ContactNoise)
    inside_outside: InsideOutside = field(default_factory=InsideOutside)
    edges: EdgeSettings | None = None  # of flat faces, where contacts with normals imply any
    spacing_m: float = 0.002
    margin_m: float = 0.01


@dataclass(frozen=True)
class Errors:
    """Root mean squares over points of both surfaces."""

    distance_m: float
    angle_rad: float  # between normals


def with_normals(p: Array, n: Array, settings: Reconstruction) -> TriMesh:
    """The estimate from contacts (k, 3) [m] and outward normals (k, 3)."""
    if settings.edges is not None:
        p_beside, n_beside = edge_contacts(p, n, settings.edges)
        p, n = np.vstack([p, p_beside]), np.vstack([n, n_beside])
    surface = ContactSurface.of(p, n, kernel=settings.kernel, noise=settings.noise)
    return _mesh(surface.follow(spacing_m=settings.spacing_m, margin_m=settings.margin_m))


def without_normals(p: Array, settings: Reconstruction, p_inside: Array | None = None) -> TriMesh:
    """The estimate from contacts (k, 3) alone; p_inside (3,) where their mean is not inside [m]."""
    seen = inside_outside_observations(p, settings.inside_outside, p_inside=p_inside)
    posterior = fit(settings.kernel, seen)
    return _mesh(
        follow_surface(posterior, p, spacing_m=settings.spacing_m, margin_m=settings.margin_m)
    )


def compare(estimate: TriMesh, truth: TriMesh, *, seed: int = 0) -> Errors:
    """Distance and angle between two surfaces, from each to the nearest points of the other.

    An estimate without triangles is as far off as the object's extents are long, and its normals
    are wrong by 90 degrees.
    """
    if len(estimate.faces) == 0:
        return Errors(float(np.linalg.norm(truth.extents)), 0.5 * math.pi)
    there = _one_way(estimate, truth, seed)
    back = _one_way(truth, estimate, seed)
    distance, angle = (np.concatenate(pair) for pair in zip(there, back, strict=True))
    return Errors(float(np.sqrt(np.mean(distance**2))), float(np.sqrt(np.mean(angle**2))))


def _one_way(a: TriMesh, b: TriMesh, seed: int) -> tuple[Array, Array]:
    """Distances [m] and angles [rad] from points of one surface to the other."""
    p, n = sample_surface(a, _POINTS, seed=seed)
    nearest, face = closest_faces(triangle_tree(b), p)
    cosine = np.clip(np.einsum("ij,ij->i", n, b.face_normals[face]), -1.0, 1.0)
    return np.linalg.norm(nearest - p, axis=1), np.arccos(cosine)


def _mesh(sheet: Sheet) -> TriMesh:
    return TriMesh(sheet.vertices, sheet.faces)
