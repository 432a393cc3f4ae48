"""How far the open hand stays from what is known of the scene."""

import dataclasses as dc

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.signed_distance import interpolate, signed_distance_grid
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, IntArray, Plane, ScalarGrid, Surface

_SPACING_M = 0.006
_PADDING_M = 0.03


@dc.dataclass(frozen=True, eq=False)
class Obstacles:
    """The estimated object and the table, as distances."""

    distance: ScalarGrid  # signed, of the object [m]
    table: Plane
    top_m: float  # height of the object over the table
    center: Array  # (3,) middle of the object's surface [m]

    @property
    def table_height_m(self) -> float:
        """Of the table's top below the object, over the floor."""
        return self.table.z_below(self.center)


def obstacles(surface: Surface, table: Plane) -> Obstacles:
    """The estimate as an obstacle.

    Raises:
        BadInput: the surface is empty.
    """
    if len(surface.faces) == 0:
        raise BadInput("an empty surface is no obstacle; estimate it from points first")
    mesh = TriMesh(surface.vertices, surface.faces)
    grid = signed_distance_grid(mesh, spacing=_SPACING_M, padding=_PADDING_M)
    center = np.average(mesh.triangles.mean(axis=1), axis=0, weights=mesh.areas)
    return Obstacles(grid, table, float(table.height(surface.vertices).max()), center)


def link_clearance(
    hand: HandModel, X_WH: Array, scene: Obstacles, angles: Array | None = None
) -> tuple[Array, float]:
    """Distances of the hand's sphere model in a pose.

    Args:
        hand: with n + 1 links.
        X_WH: hand pose (4, 4).
        scene: what is in the way.
        angles: joint angles (n,); the open hand by default.

    Returns:
        Distance of each link (n + 1,) to the object, infinite for links without spheres, and
        of the whole hand to the table [m].
    """
    centers, radii = hand.spheres(hand.lower if angles is None else angles)
    p_WS = centers @ X_WH[:3, :3].T + X_WH[:3, 3]
    gaps = interpolate(scene.distance, p_WS)[0] - radii
    first = hand.arrays.first_sphere
    links = np.full(len(hand.links), np.inf)
    np.minimum.at(links, _link_of_sphere(first), gaps)
    return links, float((scene.table.height(p_WS) - radii).min())


def _link_of_sphere(first_sphere: IntArray) -> IntArray:
    return np.repeat(np.arange(len(first_sphere) - 1), np.diff(first_sphere))
