"""The original formulation of implicit surfaces, which knows no normals (section 3.2.1).

Contacts alone say where the potential is zero, not on which side it is negative: it would be zero
everywhere. One point inside the object and several around it, with values of opposite sign, tell
(Williams and Fitzgibbon 2007).
"""

from dataclasses import dataclass

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.gpis.observations import Observations, value_observations
from vh_drake.types import Array

_GOLDEN = 0.5 * (1.0 + 5.0**0.5)


@dataclass(frozen=True)
class InsideOutside:
    """Where the added points lie; the potential is in metres, so that slopes are about one."""

    reach: float = 2.0  # distance of the outside points over that of the farthest contact
    level_share: float = 1.0  # their value over the mean distance of contacts from the centre
    contact_std_m: float = 0.0005
    added_std_m: float = 0.0005


def icosahedron() -> Array:
    """Twelve directions (12, 3), evenly spread."""
    a, b = np.array([1.0, 1.0, -1.0, -1.0]), _GOLDEN * np.array([1.0, -1.0, 1.0, -1.0])
    corners = np.column_stack([np.zeros(4), a, b])
    directions = np.vstack([corners, np.roll(corners, 1, axis=1), np.roll(corners, 2, axis=1)])
    unit: Array = directions / np.hypot(1.0, _GOLDEN)
    return unit


def ring(count: int) -> Array:
    """Directions (count, 3) in the plane z = 0."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])


def inside_outside_observations(
    p: Array,
    settings: InsideOutside | None = None,
    *,
    directions: Array | None = None,
    p_inside: Array | None = None,
) -> Observations:
    """Contacts, the point inside and the points outside, each with its value.

    Args:
        p: (n, 3) contacts [m].
        settings: distances, values and noise.
        directions: (k, 3) unit vectors from the centre to the outside points; by default twelve
            all around, for a figure in the plane a `ring`.
        p_inside: (3,) the centre; by default the mean of the contacts, which lies on the surface
            where this is flat [m].

    Returns:
        n contacts of value 0, the centre with a negative value, k outside points with the same
        positive value.

    Raises:
        BadInput: fewer than two different contacts, which leave no size to choose.
    """
    settings = settings or InsideOutside()
    directions = icosahedron() if directions is None else directions
    middle = p.mean(axis=0) if len(p) else np.zeros(3)
    centre = middle if p_inside is None else p_inside
    distance = np.linalg.norm(p - centre, axis=1)
    if len(p) == 0 or not distance.max() > 0.0:
        raise BadInput(
            f"{len(p)} contacts at one place; without normals give at least two at different places"
        )
    level = settings.level_share * float(distance.mean())
    outside = centre + settings.reach * distance.max() * directions
    touched = value_observations(p, np.zeros(len(p)), value_std_m=settings.contact_std_m)
    added = value_observations(
        np.vstack([centre, outside]),
        np.concatenate([[-level], np.full(len(outside), level)]),
        value_std_m=settings.added_std_m,
    )
    return touched.joined(added)
