"""Surfaces from signed distance fields: the last resort of repair, and of shape design."""

import fast_simplification
import numpy as np
from skimage.measure import marching_cubes

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.signed_distance import grid_around, unsigned_distance_nodes, winding_nodes
from vh_drake.types import Array, ScalarGrid

_SOLID_SHARE = 0.02  # of the box: a smaller enclosed volume is a sheet, not a solid
_PADDING_CELLS = 4
_REMESHED_TRIANGLES = 8000
_LEAST_VALUE = 0.15  # of the spacing


def extract_surface(grid: ScalarGrid, *, level: float = 0.0) -> TriMesh:
    """Watertight surface where a field, negative inside, takes a level.

    Raises:
        BadInput: the field never takes the level.
    """
    values = np.pad(grid.values - level, 1, constant_values=abs(grid.values).max() + grid.spacing)
    if not values.min() < 0:
        raise BadInput("the solid is thinner than the grid; use a smaller spacing")
    least = _LEAST_VALUE * grid.spacing  # no vertex comes near a node: slivers stall simplify()
    values = np.where(np.abs(values) < least, np.where(values < 0, -least, least), values)
    vertices, faces, _, _ = marching_cubes(values, 0.0)
    positions = grid.origin + grid.spacing * (vertices.astype(np.float64) - 1)
    mesh = TriMesh(positions, faces.astype(np.int64))
    return mesh if mesh.volume > 0 else mesh.flipped()


def remesh(mesh: TriMesh, *, nodes: int, as_sheet: bool = False) -> tuple[TriMesh, str]:
    """Watertight surface around any triangles, and a sentence on how it was made.

    Where the triangles wrap a volume, it is the solid's surface; else, or on request, a shell
    of a cell and a half to each side of them.

    Args:
        mesh: Open, self-crossing or non-manifold.
        nodes: Grid nodes along the longest side.
        as_sheet: Leave openings open.
    """
    spacing = float(mesh.extents.max()) / (nodes - 1 - 2 * _PADDING_CELLS)
    origin, shape = grid_around(mesh, spacing=spacing, padding=_PADDING_CELLS * spacing)
    triangles = (mesh.triangles - origin) / spacing
    distance = unsigned_distance_nodes(triangles, shape) * spacing
    inside = winding_nodes(triangles, shape) >= 0.5
    least = _SOLID_SHARE * np.prod(np.maximum(mesh.extents, spacing))
    if as_sheet or inside.sum() * spacing**3 < least:
        surface = extract_surface(ScalarGrid(origin, spacing, distance), level=1.5 * spacing)
        sentence = f"Thickened the open sheet to {3e3 * spacing:.1f} mm."
    else:
        signed = np.where(inside, -distance, distance)
        surface = extract_surface(ScalarGrid(origin, spacing, signed))
        sentence = f"Rebuilt the open surface on a grid of {spacing * 1e3:.1f} mm."
    return simplify(surface, _REMESHED_TRIANGLES), sentence


def simplify(mesh: TriMesh, triangles: int, *, aggressiveness: float = 5.0) -> TriMesh:
    """Collapse edges until about so many triangles are left (quadric errors)."""
    if len(mesh.faces) <= triangles:
        return mesh
    scale = mesh.diagonal  # the library works in single precision
    points: Array = ((mesh.vertices - mesh.bounds[0]) / scale).astype(np.float32)
    vertices, faces = fast_simplification.simplify(
        points, mesh.faces.astype(np.int32), target_count=triangles, agg=aggressiveness
    )
    return TriMesh(vertices.astype(np.float64) * scale + mesh.bounds[0], faces.astype(np.int64))
