"""The triangles of all that a camera sees in a scene graph."""

import functools
from pathlib import Path

import numpy as np
import trimesh
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    QueryObject,
    Role,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform

from vh_drake.errors import BadInput
from vh_drake.types import Array

_HALF_SPACE_M = 20.0  # edge of the square that stands for a half space [m]


def perceived_triangles(query: QueryObject) -> Array:
    """Corners (n, 3, 3) in W [m] of all geometry with the perception role.

    Raises:
        BadInput: a mesh file cannot be read.
    """
    inspector = query.inspector()
    parts = [np.zeros((0, 3, 3))]
    for geometry_id in inspector.GetAllGeometryIds(Role.kPerception):
        X_WG: RigidTransform = query.GetPoseInWorld(geometry_id)
        corners = shape_triangles(inspector.GetShape(geometry_id))
        parts.append(X_WG.multiply(corners.reshape(-1, 3).T).T.reshape(-1, 3, 3))
    return np.concatenate(parts)


def shape_triangles(shape: Shape) -> Array:
    """Corners (n, 3, 3) of a shape in its own frame [m].

    Raises:
        BadInput: a mesh that is not a readable file, or a shape that has no surface here.
    """
    match shape:
        case Box():
            # A view would keep Drake's context from the query alive in trimesh's cycles.
            return _triangles(trimesh.creation.box(np.array(shape.size())))
        case Sphere():
            return _ball() * shape.radius()
        case Ellipsoid():
            return _ball() * [shape.a(), shape.b(), shape.c()]
        case Cylinder():
            return _triangles(trimesh.creation.cylinder(shape.radius(), shape.length(), 48))
        case Capsule():
            return _triangles(_capsule(shape.radius(), shape.length()))
        case HalfSpace():
            return _triangles(_square(_HALF_SPACE_M))
        case Mesh() | Convex():
            if not shape.source().is_path():
                raise BadInput("ray casting needs meshes in files; this one is in memory")
            return _file(str(shape.source().path())) * shape.scale3()
    raise BadInput(f"ray casting knows no {type(shape).__name__}; render with EGL instead")


def _triangles(mesh: trimesh.Trimesh) -> Array:
    return np.asarray(mesh.triangles, dtype=float)


def _capsule(radius: float, length: float) -> trimesh.Trimesh:
    mesh = trimesh.creation.capsule(height=length, radius=radius, count=[24, 24])
    mesh.apply_translation([0.0, 0.0, -mesh.bounds.mean(axis=0)[2]])
    return mesh


def _square(edge: float) -> trimesh.Trimesh:
    h = 0.5 * edge
    corners = [[-h, -h, 0.0], [h, -h, 0.0], [h, h, 0.0], [-h, h, 0.0]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


@functools.cache
def _ball() -> Array:
    return _triangles(trimesh.creation.icosphere(subdivisions=3))


@functools.lru_cache(maxsize=256)
def _file(path: str) -> Array:
    if not Path(path).is_file():
        raise BadInput(f"no mesh at {path}")
    try:
        return _triangles(trimesh.load(path, force="mesh", process=False))
    except Exception as error:  # trimesh raises many types; all mean an unreadable mesh.
        raise BadInput(f"{path} cannot be read as a mesh: {error}") from error
