"""Objects as rigid bodies of a MultibodyPlant."""

from typing import Literal

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import (
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    Convex,
    Cylinder,
    InMemoryMesh,
    Mesh,
    ProximityProperties,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import RigidBody, RotationalInertia, SpatialInertia

from vh_drake.errors import UnknownName
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import simplify
from vh_drake.objects.model import ObjectModel
from vh_drake.objects.primitives import BoxShape, CylinderShape, Primitive

ContactModel = Literal["hydroelastic", "point"]
_CONTACT_MODELS = ("hydroelastic", "point")
VISUAL_TRIANGLES = 2500
_RESOLUTION_HINT_M = 0.015
_SUPPORT_POINTS = 24
_SUPPORT_RADIUS_M = 5e-4
_COLOR = np.array([0.85, 0.55, 0.2, 1.0])

Placed = tuple[Shape, RigidTransform]


def add_object(
    plant: MultibodyPlant,
    model: ObjectModel,
    *,
    contact: ContactModel = "hydroelastic",
    name: str = "object",
) -> RigidBody:
    """Add an object as a free body in a model instance of its own.

    The body frame is the object's frame O. The fine mesh is seen by Meshcat and by cameras.
    For contact the object is rigid: its exact shape where it has one; else, in hydroelastic
    contact, one coarse mesh with its concavities, and in point contact its convex pieces.

    Args:
        plant: Registered with a SceneGraph and not yet finalized.
        model: The object.
        contact: Which kind of contact geometry is made.
        name: Of the body and of the model instance.

    Raises:
        UnknownName: no such contact model.
    """
    if contact not in _CONTACT_MODELS:
        raise UnknownName("contact model", contact, list(_CONTACT_MODELS))
    instance = plant.AddModelInstance(name)
    body = plant.AddRigidBody(name, instance, spatial_inertia(model))
    visual = mesh_shape(simplify(model.mesh, VISUAL_TRIANGLES), f"{name}_visual")
    plant.RegisterVisualGeometry(body, RigidTransform(), visual, f"{name}_visual", _COLOR)
    properties = _contact_properties(model.friction, contact)
    for i, (shape, X_OS) in enumerate(contact_shapes(model, contact)):
        plant.RegisterCollisionGeometry(body, X_OS, shape, f"{name}_contact_{i}", properties)
    return body


def spatial_inertia(model: ObjectModel) -> SpatialInertia:
    """Spatial inertia about the origin of O, expressed in O."""
    moments, (xy, xz, yz) = np.diag(model.inertia), model.inertia[(0, 0, 1), (1, 2, 2)]
    return SpatialInertia.MakeFromCentralInertia(
        model.mass_kg, model.com, RotationalInertia(*moments, xy, xz, yz)
    )


def contact_shapes(model: ObjectModel, contact: ContactModel) -> list[Placed]:
    """Shapes for contact and their poses in O."""
    if contact == "hydroelastic":
        return [_hydroelastic_shape(model)]
    return [*_convex_shapes(model), *_support_points(model)]


def _hydroelastic_shape(model: ObjectModel) -> Placed:
    """The exact shape, or the coarse mesh."""
    if model.primitive is not None:
        return _exact_shape(model.primitive)
    return mesh_shape(model.contact_mesh, f"{model.name}_contact"), RigidTransform()


def _convex_shapes(model: ObjectModel) -> list[Placed]:
    """The exact shape, or the convex pieces."""
    if model.primitive is not None:
        return [_exact_shape(model.primitive)]
    return [
        (Convex(points=vertices.T, label=f"{model.name}_{i}"), RigidTransform())
        for i, vertices in enumerate(model.convex_pieces)
    ]


def _support_points(model: ObjectModel) -> list[Placed]:
    """Small balls just inside the hull's corners.

    Point contact knows one point for each pair of shapes, on which nothing stands upright;
    the balls give a flat face several points to stand on.
    """
    corners = model.mesh.convex_hull.vertices
    chosen = [int(np.linalg.norm(corners - model.com, axis=1).argmax())]
    gap = np.full(len(corners), np.inf)
    while len(chosen) < min(_SUPPORT_POINTS, len(corners)):
        gap = np.minimum(gap, np.linalg.norm(corners - corners[chosen[-1]], axis=1))
        chosen.append(int(gap.argmax()))
    inward = model.com - corners[chosen]
    inward *= _SUPPORT_RADIUS_M / np.linalg.norm(inward, axis=1, keepdims=True)
    centers = corners[chosen] + inward
    return [(Sphere(_SUPPORT_RADIUS_M), RigidTransform(p_OS)) for p_OS in centers]


def mesh_shape(mesh: TriMesh, label: str) -> Mesh:
    """A mesh that Drake reads from memory."""
    return Mesh(mesh_data=InMemoryMesh(mesh_file=MemoryFile(obj_text(mesh), ".obj", label)))


def obj_text(mesh: TriMesh) -> str:
    """A mesh in Wavefront format, to a hundredth of a millimetre, with a normal a face."""
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in mesh.vertices]
    lines += [f"vn {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.face_normals]
    faces = enumerate(mesh.faces + 1, start=1)
    lines += [f"f {i}//{n} {j}//{n} {k}//{n}" for n, (i, j, k) in faces]
    return "\n".join([*lines, ""])


def _exact_shape(primitive: Primitive) -> Placed:
    """A library shape in Drake's terms."""
    X_OS = RigidTransform(np.array(primitive.center))
    if isinstance(primitive, BoxShape):
        return Box(*primitive.size), X_OS
    if isinstance(primitive, CylinderShape):
        return Cylinder(primitive.radius, primitive.length), X_OS
    return Sphere(primitive.radius), X_OS


def _contact_properties(friction: float, contact: ContactModel) -> ProximityProperties:
    """Friction, and a rigid hydroelastic representation where that is asked for."""
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(friction, friction), properties=properties)
    if contact == "hydroelastic":
        AddRigidHydroelasticProperties(_RESOLUTION_HINT_M, properties)
    return properties
