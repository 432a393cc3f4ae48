"""Mass properties of a body of uniform density, from its surface."""

from dataclasses import dataclass

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.types import Array


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass, its centre and its rotational inertia, in the mesh's frame O."""

    mass_kg: float
    com: Array  # (3,) centre of mass [m]
    inertia: Array  # (3, 3) about the centre of mass [kg m²]


def mass_properties(mesh: TriMesh, mass_kg: float) -> MassProperties:
    r"""Mass properties by summing signed tetrahedra from the origin (Blow & Binstock 2004).

    A tetrahedron with corners 0, a, b, c has volume v = a · (b × c) / 6, centre (a + b + c) / 4
    and second moment

    .. math:: C = \frac{v}{20}\left(s s^\top + a a^\top + b b^\top + c c^\top\right),
              \quad s = a + b + c.

    Raises:
        BadInput: the mass is not positive, or the mesh is open or encloses nothing.
    """
    if not (np.isfinite(mass_kg) and mass_kg > 0):
        raise BadInput(f"mass {mass_kg:g} kg is not positive; give a mass in kg above zero")
    if not mesh.is_watertight or mesh.volume <= 0:
        raise BadInput("mass properties need a watertight mesh; repair it first")
    origin = mesh.bounds.mean(axis=0)  # sums cancel less near the body
    corners = mesh.triangles - origin  # (f, 3, 3)
    a, b, c = corners.swapaxes(0, 1)
    volumes = np.einsum("fi,fi->f", a, np.cross(b, c)) / 6
    sums = corners.sum(axis=1)
    density = mass_kg / volumes.sum()
    com = volumes @ sums / 4 / volumes.sum()
    moments = np.einsum("f,fi,fj->ij", volumes, sums, sums)
    moments += np.einsum("f,fki,fkj->ij", volumes, corners, corners)
    covariance = density * moments / 20 - mass_kg * np.outer(com, com)
    inertia = np.trace(covariance) * np.eye(3) - covariance
    return MassProperties(mass_kg, com + origin, (inertia + inertia.T) / 2)
