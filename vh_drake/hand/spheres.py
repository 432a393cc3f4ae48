"""Collision shapes covered by spheres, so that distances to a field are one look-up each."""

import numpy as np
import trimesh
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, Mesh, Shape, Sphere

from vh_drake.errors import BadInput
from vh_drake.types import Array

_LARGEST_RADIUS = 0.0125  # Of spheres in boxes, cylinders and meshes [m]
_MESH_SPHERES = 48


def cover(shape: Shape) -> tuple[Array, Array]:
    """Spheres inside a shape that reach its surface.

    Edges of boxes and rims of cylinders are rounded by the spheres' radius; between two
    spheres of a capsule the surface is at most 6 % of its radius lower.

    Returns:
        Centres (n, 3) in the shape's frame and radii (n,) [m].

    Raises:
        BadInput: the shape has no bounded volume.
    """
    if isinstance(shape, Sphere):
        return np.zeros((1, 3)), np.array([shape.radius()])
    if isinstance(shape, Capsule):
        return _capsule(shape.radius(), shape.length())
    if isinstance(shape, Box):
        return _box(np.asarray(shape.size()))
    if isinstance(shape, Cylinder):
        return _cylinder(shape.radius(), shape.length())
    if isinstance(shape, Ellipsoid):
        ball = trimesh.creation.icosphere(subdivisions=3)
        return _mesh(ball.apply_scale([shape.a(), shape.b(), shape.c()]))
    if isinstance(shape, Mesh | Convex):
        return _mesh(_read_mesh(shape))
    raise BadInput(f"a hand can't be made of {type(shape).__name__}; use shapes with a volume")


def _capsule(radius: float, length: float) -> tuple[Array, Array]:
    count = int(np.ceil(length / (0.7 * radius))) + 1
    centers = np.zeros((count, 3))
    centers[:, 2] = np.linspace(-length / 2, length / 2, count)
    return centers, np.full(count, radius)


def _box(size: Array) -> tuple[Array, Array]:
    radius = min(size.min() / 2, _LARGEST_RADIUS)
    axes = []
    for side in size:
        count = int(np.ceil((side - 2 * radius) / (2 * radius))) + 1
        axes.append(np.linspace(radius - side / 2, side / 2 - radius, count))
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    at_surface = (np.abs(nodes) > size / 2 - 1.01 * radius).any(axis=1)
    centers: Array = nodes[at_surface]
    return centers, np.full(len(centers), radius)


def _cylinder(radius: float, length: float) -> tuple[Array, Array]:
    small = min(length / 2, radius, _LARGEST_RADIUS)
    ring = radius - small
    around = max(int(np.ceil(2 * np.pi * ring / (2 * small))), 1)
    layers = int(np.ceil((length - 2 * small) / (2 * small))) + 1
    angles = 2 * np.pi * np.arange(around) / around
    heights = np.linspace(small - length / 2, length / 2 - small, layers)
    circle = np.column_stack([ring * np.cos(angles), ring * np.sin(angles)])
    centers = np.array([[x, y, z] for z in heights for x, y in circle])
    return centers, np.full(len(centers), small)


def _mesh(mesh: trimesh.Trimesh) -> tuple[Array, Array]:
    """Spheres that touch evenly spread surface points from inside."""
    radius = min(float(mesh.extents.min()) / 3, _LARGEST_RADIUS)
    points, faces = trimesh.sample.sample_surface_even(mesh, _MESH_SPHERES, seed=0)
    centers: Array = np.asarray(points) - radius * mesh.face_normals[faces]
    return centers, np.full(len(centers), radius)


def _read_mesh(shape: Mesh | Convex) -> trimesh.Trimesh:
    name = str(shape.source().path())
    try:
        mesh = trimesh.load(name, force="mesh")
    except Exception as error:  # trimesh raises many types; all mean an unusable file.
        raise BadInput(f"can't read the hand's mesh {name}: {error}") from error
    scale = shape.scale3()
    mesh.apply_scale(scale)
    return mesh
