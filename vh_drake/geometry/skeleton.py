r"""Curve skeletons of solids: the lines in their middle, with the cross sections around them.

The solid is thinned to a line of voxels (`vh_drake.geometry.thinning`), spurs shorter than the
solid is thick are dropped, and each branch is smoothed under a pull to the centroids of its
cross sections, which makes it central to a fraction of a voxel. A cross section is what rays
across the line meet; free ends are drawn on to the surface. In grasp planning this does what
the mean-curvature skeleton of Vahrenkamp et al. 2018 does (thesis, section 4.2.4).

Hollow things such as mugs have no such line: theirs runs through the wall. That shows in rays
that leave the solid and meet it again, whose share tells how far to trust a skeleton.
"""

import dataclasses as dc

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vh_drake.errors import BadInput
from vh_drake.geometry.line_graph import FREE, Branch, pruned, traced
from vh_drake.geometry.signed_distance import interpolate
from vh_drake.geometry.thinning import thinned
from vh_drake.types import Array, ScalarGrid

RAYS = 16  # of a cross section
TRUSTED = 0.92  # On 53 estimates mugs, lying cups and a clamp stayed below, all others above
_SPUR = 1.0  # A branch shorter than this share of the radius that it springs from is none
_POINT = 0.5  # A line shorter than this share of the solid's half thickness has no direction
_ROUNDS = 3  # of smoothing and centring
_SMOOTHING = 4  # steps a round
_LONGEST_RAY = 3.0  # of a section, relative to the shortest, when its centroid is sought
_END_NODES = 3  # from which a line is drawn on; more where the solid is thick
_STEPS = 200  # at most, along a ray
_LEAST_STEP = 0.25  # of the grid's spacing
_GAP = 1.5  # of the grid's spacing: how far outside a ray must be before it may meet the solid


@dc.dataclass(frozen=True, eq=False)
class Line:
    """One branch of a skeleton, from end to end, with its k cross sections."""

    p: Array  # (k, 3) nodes [m]; a loop ends where it starts
    tangent: Array  # (k, 3) unit vectors; zero where the line is a single point
    rays: Array  # (k, RAYS, 3) unit vectors at even angles; ray i + RAYS / 2 is opposite to i
    reach: Array  # (k, RAYS) distance of the surface along each [m]
    free: tuple[bool, bool]  # whether first and last node are ends of the solid

    @property
    def length(self) -> float:
        """From the first node to the last [m]."""
        return _length(self.p)

    @property
    def widths(self) -> Array:
        """Diameters (k, RAYS / 2) of the cross sections along the first half of the rays [m]."""
        half = RAYS // 2
        return self.reach[:, :half] + self.reach[:, half:]


@dc.dataclass(frozen=True, eq=False)
class Skeleton:
    """The lines of a solid."""

    lines: tuple[Line, ...]
    trust: float  # share of the rays that meet no second wall

    @property
    def trusted(self) -> bool:
        """Whether the lines run where the solid's middle is; not so in mugs."""
        return self.trust >= TRUSTED


def curve_skeleton(distance: ScalarGrid) -> Skeleton:
    """The skeleton of a solid from the signed distance around it, negative inside [m].

    A part without a direction, such as a ball, is a line of one node.

    Raises:
        BadInput: no node of the grid is inside.
    """
    solid = distance.values < 0
    if not solid.any():
        raise BadInput("no skeleton: the surface is empty, or encloses no node of the grid")
    lines = tuple(_line(branch, distance) for branch in _branches(solid, distance))
    return Skeleton(lines, 1.0 - _second_wall_share(lines, distance))


def wall_distances(distance: ScalarGrid, p: Array, directions: Array) -> Array:
    """How far (n,) the surface is from points (n, 3) inside along unit vectors (n, 3) [m].

    Sphere tracing; 0 for points outside.
    """
    way, value = np.zeros(len(p)), interpolate(distance, p)[0]
    inside = np.flatnonzero(value < 0)
    least = _LEAST_STEP * distance.spacing
    for _ in range(_STEPS):
        if len(inside) == 0:
            break
        before = value[inside]
        step = np.maximum(-before, least)
        ahead = p[inside] + (way[inside] + step)[:, None] * directions[inside]
        after = interpolate(distance, ahead)[0]
        met = after >= 0
        way[inside] += np.where(met, step * before / np.minimum(before - after, -1e-12), step)
        value[inside] = after
        inside = inside[~met]
    return way


def tangents(p: Array) -> Array:
    """Unit vectors (k, 3) along a line of points (k, 3); zero for a single point."""
    if len(p) == 1:
        return np.zeros((1, 3))
    around = np.vstack([p[-2], p, p[1]]) if _is_loop(p) else np.vstack([p[0], p, p[-1]])
    chord = around[2:] - around[:-2]
    unit: Array = chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-12)
    return unit


def _branches(solid: NDArray[np.bool_], distance: ScalarGrid) -> tuple[Branch, ...]:
    """Branches in metres, without spurs."""
    raw = traced(thinned(solid))
    depth = ndimage.distance_transform_edt(solid)
    ends = [(b.start, b.p[0]) for b in raw] + [(b.end, b.p[-1]) for b in raw]
    thickness = {
        junction: _SPUR * float(depth[tuple(np.rint(p).astype(int))])
        for junction, p in ends
        if junction != FREE
    }
    return tuple(
        dc.replace(b, p=distance.origin + distance.spacing * b.p) for b in pruned(raw, thickness)
    )


def _line(branch: Branch, distance: ScalarGrid) -> Line:
    p = _resampled(branch.p, distance.spacing)
    loop = _is_loop(p)
    held = (loop or branch.start != FREE, loop or branch.end != FREE)
    half_thickness = float(-interpolate(distance, p)[0].min())
    if not any(held) and _length(p) < _POINT * half_thickness:
        p = p[len(p) // 2 : len(p) // 2 + 1]
    for _ in range(_ROUNDS if len(p) > 2 else 0):
        p = _centred(_smoothed(p), distance, held)
    free = (not held[0], not held[1])
    if len(p) > 1:
        p = _carried_on(p, distance, free)
    tangent = tangents(p)
    rays = _rays(tangent)
    return Line(p, tangent, rays, _reach(p, rays, distance), free)


def _is_loop(p: Array) -> bool:
    return len(p) > 3 and bool(np.allclose(p[0], p[-1]))


def _length(p: Array) -> float:
    return float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())


def _resampled(p: Array, spacing: float) -> Array:
    """The same line with about evenly spaced nodes."""
    way = np.concatenate([[0.0], np.linalg.norm(np.diff(p, axis=0), axis=1).cumsum()])
    at = np.linspace(0.0, way[-1], int(np.rint(way[-1] / spacing)) + 1)
    return np.column_stack([np.interp(at, way, p[:, axis]) for axis in range(3)])


def _smoothed(p: Array) -> Array:
    """Steps towards the mean of both neighbours; the ends stay."""
    for _ in range(_SMOOTHING):
        middle = 0.5 * p[1:-1] + 0.25 * (p[:-2] + p[2:])
        p = np.vstack([p[:1], middle, p[-1:]])
    return p


def _centred(p: Array, distance: ScalarGrid, held: tuple[bool, bool]) -> Array:
    r"""Nodes moved half of the way to the centroid of what rays across the line reach.

    In polar coordinates a section's centroid is :math:`\int r^3 e / 3 \,/ \int r^2 / 2`. Rays
    that leave through another branch say nothing about this one, so long ones are cut.
    """
    rays = _rays(tangents(p))
    reach = _reach(p, rays, distance)
    reach = np.minimum(reach, _LONGEST_RAY * reach.min(axis=1, keepdims=True))
    moment = (reach[..., None] ** 3 * rays).sum(axis=1) / 3
    area = np.maximum((reach**2).sum(axis=1), 1e-18)[:, None] / 2
    moved = p + 0.5 * moment / area
    stays = interpolate(distance, moved)[0] >= 0
    stays[[0, -1]] |= held
    return np.where(stays[:, None], p, moved)


def _carried_on(p: Array, distance: ScalarGrid, free: tuple[bool, bool]) -> Array:
    """A line whose free ends are drawn straight on to the surface."""
    if free[1]:
        p = _last_carried_on(p, distance)
    return _last_carried_on(p[::-1], distance)[::-1] if free[0] else p


def _last_carried_on(p: Array, distance: ScalarGrid) -> Array:
    depth = float(-interpolate(distance, p[-1:])[0][0])
    nodes = max(int(np.ceil(depth / distance.spacing)), _END_NODES)
    along = p[-1] - p[max(len(p) - 1 - nodes, 0)]
    along = along / max(float(np.linalg.norm(along)), 1e-12)
    way = float(wall_distances(distance, p[-1:], along[None])[0])
    if way == 0.0:
        return p
    count = max(int(np.rint(way / distance.spacing)), 1)
    steps = way * np.arange(1, count + 1) / count
    return np.vstack([p, p[-1] + steps[:, None] * along])


def _rays(tangent: Array) -> Array:
    """Directions (k, RAYS, 3) at even angles across tangents (k, 3); across z where these are 0."""
    axis = np.where(tangent.any(axis=1, keepdims=True), tangent, [[0.0, 0.0, 1.0]])
    helper = np.where(np.abs(axis[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    u = np.cross(helper, axis)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(axis, u)
    angle = 2 * np.pi * np.arange(RAYS) / RAYS
    rays: Array = np.cos(angle)[:, None] * u[:, None] + np.sin(angle)[:, None] * v[:, None]
    return rays


def _reach(p: Array, rays: Array, distance: ScalarGrid) -> Array:
    starts = np.repeat(p, RAYS, axis=0)
    return wall_distances(distance, starts, rays.reshape(-1, 3)).reshape(-1, RAYS)


def _second_wall_share(lines: tuple[Line, ...], distance: ScalarGrid) -> float:
    """Share of all rays that meet the solid again after they left it."""
    spacing = distance.spacing
    size = spacing * float(np.linalg.norm(distance.values.shape))
    beyond = np.arange(_GAP * spacing, size, spacing)
    p = np.vstack([line.p for line in lines])[:, None, None]
    reach = np.vstack([line.reach for line in lines])[..., None] + beyond
    rays = np.vstack([line.rays for line in lines])[:, :, None]
    values = interpolate(distance, (p + reach[..., None] * rays).reshape(-1, 3))[0]
    return float((values.reshape(reach.shape) < 0).any(axis=-1).mean())
