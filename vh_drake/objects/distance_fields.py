"""Solids as signed distance fields, for shapes that no lathe turns; negative inside.

A field takes points (..., 3) [m] to values (...,) [m]. Unions and cuts give a bound of
the distance rather than the distance, with the right zero set.
"""

from collections.abc import Callable, Sequence

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import extract_surface, simplify
from vh_drake.types import Array, ScalarGrid

Field = Callable[[Array], Array]
Vector = tuple[float, float, float]

_CELLS = 100  # along the longest side
_TRIANGLES = 3000
_PROJECTIONS = 3
_STEP_M = 1e-5


def ball(center: Vector, radius: float) -> Field:
    """A ball."""
    return lambda p: np.linalg.norm(p - np.array(center), axis=-1) - radius


def rounded_box(center: Vector, size: Vector, radius: float) -> Field:
    """A box of outer size, edges rounded."""
    half = np.array(size) / 2 - radius

    def field(p: Array) -> Array:
        q = np.abs(p - np.array(center)) - half
        outside = np.linalg.norm(np.maximum(q, 0.0), axis=-1)
        return np.asarray(outside + np.minimum(q.max(axis=-1), 0.0) - radius)

    return field


def cone_capsule(start: Vector, end: Vector, radius_start: float, radius_end: float) -> Field:
    """Balls of linearly changing radius along a segment, nearly a distance for slim cones."""
    a, axis = np.array(start), np.array(end) - np.array(start)

    def field(p: Array) -> Array:
        t = np.clip((p - a) @ axis / (axis @ axis), 0.0, 1.0)
        radius = radius_start + t * (radius_end - radius_start)
        return np.asarray(np.linalg.norm(p - a - t[..., None] * axis, axis=-1) - radius)

    return field


def rod(start: Vector, end: Vector, radius: float, *, edge: float = 0.001) -> Field:
    """A cylinder with flat ends, edges rounded."""
    a, axis = np.array(start), np.array(end) - np.array(start)
    length = float(np.linalg.norm(axis))

    def field(p: Array) -> Array:
        along = (p - a) @ axis / length
        across = np.linalg.norm(p - a - along[..., None] * (axis / length), axis=-1)
        q = np.stack([across - radius, np.abs(along - length / 2) - length / 2], axis=-1) + edge
        outside = np.linalg.norm(np.maximum(q, 0.0), axis=-1)
        return np.asarray(outside + np.minimum(q.max(axis=-1), 0.0) - edge)

    return field


def ring(center: Vector, radius: float, thickness: float) -> Field:
    """A torus about y: `thickness` is the radius of its section."""

    def field(p: Array) -> Array:
        q = p - np.array(center)
        in_plane = np.hypot(q[..., 0], q[..., 2]) - radius
        return np.asarray(np.hypot(in_plane, q[..., 1]) - thickness)

    return field


def stretched(field: Field, factors: Vector) -> Field:
    """A field squeezed along the axes."""
    return lambda p: np.asarray(field(p / np.array(factors)) * min(factors))


def union(*fields: Field, blend: float = 0.0) -> Field:
    """All of the solids; edges between them filled over a length (polynomial smooth minimum)."""

    def field(p: Array) -> Array:
        result = fields[0](p)
        for other in fields[1:]:
            value = other(p)
            gap = np.maximum(blend - np.abs(result - value), 0.0)
            fill = gap**2 / (4 * blend) if blend > 0 else 0.0
            result = np.minimum(result, value) - fill
        return np.asarray(result)

    return field


def cut(solid: Field, *tools: Field) -> Field:
    """The solid without the tools."""
    return lambda p: np.maximum.reduce([solid(p), *(-tool(p) for tool in tools)])


def chain(points: Sequence[Vector], radii: Sequence[float], *, blend: float = 0.0) -> Field:
    """Capsules along a polyline."""
    links = [
        cone_capsule(points[i], points[i + 1], radii[i], radii[i + 1])
        for i in range(len(points) - 1)
    ]
    return union(*links, blend=blend)


def mesh_field(field: Field, low: Vector, high: Vector) -> TriMesh:
    """Watertight surface of a field within a box, about 3,000 triangles, standing on z = 0.

    Raises:
        BadInput: the solid reaches beyond the box.
    """
    origin, size = np.array(low), np.array(high) - np.array(low)
    spacing = float(size.max()) / _CELLS
    axes = [
        start + spacing * np.arange(int(np.ceil(s / spacing)) + 1)
        for start, s in zip(origin, size, strict=True)
    ]
    values = field(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    interior = values[1:-1, 1:-1, 1:-1]
    if values.min() < interior.min() or (values < 0).sum() != (interior < 0).sum():
        raise BadInput(f"the shape reaches beyond its box {low} to {high}")
    mesh = simplify(extract_surface(ScalarGrid(origin, spacing, values)), _TRIANGLES)
    vertices = _project(field, mesh.vertices)
    return TriMesh(vertices - [0.0, 0.0, vertices[:, 2].min()], mesh.faces)


def _project(field: Field, points: Array) -> Array:
    """Move points onto the zero set by damped Newton steps along the gradient."""
    steps = _STEP_M * np.eye(3)
    for _ in range(_PROJECTIONS):
        probes = points[:, None, None] + np.stack([steps, -steps])  # (n, 2, 3, 3)
        plus, minus = field(probes).swapaxes(0, 1)
        gradient = (plus - minus) / (2 * _STEP_M)
        length = np.maximum((gradient**2).sum(axis=1, keepdims=True), 0.25)
        points = points - 0.8 * field(points)[:, None] * gradient / length
    return points
