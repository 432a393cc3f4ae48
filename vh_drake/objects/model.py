"""An object as the rest of the project knows it."""

from dataclasses import dataclass
from functools import cached_property

from vh_drake.geometry.contact_mesh import ContactMesh, coarsen
from vh_drake.geometry.decomposition import convex_pieces
from vh_drake.geometry.inertia import mass_properties
from vh_drake.geometry.meshes import TriMesh
from vh_drake.objects.primitives import Primitive
from vh_drake.types import Array

DEFAULT_FRICTION = 0.8


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """A rigid object in its own frame O; ground truth that only simulation may see."""

    name: str
    mesh: TriMesh  # watertight [m]
    mass_kg: float
    com: Array  # (3,) centre of mass p_OCom [m]
    inertia: Array  # (3, 3) about the centre of mass, axes of O [kg m²]
    friction: float = DEFAULT_FRICTION  # static and dynamic Coulomb coefficient
    primitive: Primitive | None = None  # exact contact shape, where there is one
    mass_source: str = "given"  # where the mass comes from, in words
    report: tuple[str, ...] = ()  # what was done to the file, in sentences

    @cached_property
    def contact(self) -> ContactMesh:
        """Coarse watertight mesh for hydroelastic contact, about 300 triangles."""
        return coarsen(self.mesh)

    @property
    def contact_mesh(self) -> TriMesh:
        """The mesh of `contact`."""
        return self.contact.mesh

    @cached_property
    def convex_pieces(self) -> tuple[Array, ...]:
        """Convex pieces for point contact: their vertices, (n_i, 3) each [m]."""
        return convex_pieces(self.mesh)


def make_object(
    name: str,
    mesh: TriMesh,
    mass_kg: float,
    *,
    mass_source: str = "given",
    primitive: Primitive | None = None,
    report: tuple[str, ...] = (),
) -> ObjectModel:
    """An object of uniform density from a watertight mesh.

    Raises:
        BadInput: the mesh is open or the mass not positive.
    """
    properties = mass_properties(mesh, mass_kg)
    return ObjectModel(
        name,
        mesh,
        mass_kg,
        properties.com,
        properties.inertia,
        primitive=primitive,
        mass_source=mass_source,
        report=report,
    )
