"""The signed distance around an estimated surface, and what follows from it."""

import dataclasses as dc
from typing import NamedTuple

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.signed_distance import signed_distance_grid
from vh_drake.types import Array, Plane, ScalarGrid, Surface


class FieldArrays(NamedTuple):
    """Signed distance and table for compiled kernels."""

    values: Array  # (nx, ny, nz) [m], negative inside
    origin: Array  # (3,) [m]
    spacing: float  # [m]
    table: Array  # (4,) upward unit normal and offset


@dc.dataclass(frozen=True, eq=False)
class ObjectField:
    """An object as grasp planning sees it."""

    distance: ScalarGrid  # signed distance [m]
    table: Plane
    center: Array  # (3,) centre of mass at uniform density [m]
    size_m: float  # largest distance of the surface from the centre

    @property
    def arrays(self) -> FieldArrays:
        """For compiled kernels."""
        table = np.append(self.table.normal, self.table.offset).astype(np.float64)
        values = np.ascontiguousarray(self.distance.values, np.float64)
        return FieldArrays(values, self.distance.origin, float(self.distance.spacing), table)


def object_field(
    surface: Surface, table: Plane, *, spacing_m: float = 0.004, padding_m: float = 0.02
) -> ObjectField:
    """Signed distance of a surface on a grid, with centre of mass and size.

    Raises:
        BadInput: the surface is empty, not finite, or encloses no node of the grid.
    """
    if len(surface.faces) == 0:
        raise BadInput("the estimated surface is empty; add points or contacts first")
    if not np.isfinite(surface.vertices).all():
        raise BadInput("the estimated surface has vertices that are not finite")
    mesh = TriMesh(surface.vertices, surface.faces)
    grid = signed_distance_grid(mesh, spacing=spacing_m, padding=padding_m)
    center = inside_centroid(grid)
    size = float(np.linalg.norm(surface.vertices - center, axis=1).max())
    return ObjectField(grid, table, center, size)


def inside_centroid(grid: ScalarGrid) -> Array:
    """Centroid (3,) of the inside; cells that the surface cuts count in part [m].

    Raises:
        BadInput: no node lies inside.
    """
    weights = np.clip(0.5 - grid.values / grid.spacing, 0.0, 1.0)
    if not (grid.values < 0).any():
        raise BadInput(
            f"the surface encloses no node of a grid of {1000 * grid.spacing:g} mm; "
            "it is open, turned inside out or too thin"
        )
    nodes = np.stack(np.meshgrid(*map(np.arange, grid.values.shape), indexing="ij"), axis=-1)
    centroid: Array = np.average(nodes.reshape(-1, 3), axis=0, weights=weights.ravel())
    return grid.origin + grid.spacing * centroid
