"""Hand poses of a planner's proposals: aligned, off the object, above the table.

All that is here lies in table axes T: z is the table's normal, and z = 0 its top. Results are
poses in the world.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.motions import MotionArrays, collect_pose, hand_axes, motion_of
from vh_drake.grasping.placement import free_lift, way_to_contact
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Plane, Surface

_BAND_M = 0.025  # Half the width of the slice in which the object's width is taken
_SAMPLES = 800  # points that stand for the surface
_UP = np.array([0.0, 0.0, 1.0])


@dc.dataclass(frozen=True, eq=False)
class Site:
    """What shall be grasped, with what, and how."""

    hand: HandModel
    field: ObjectField
    settings: PlannerSettings
    X_WT: Array  # (4, 4)
    motions: dict[str, MotionArrays]  # by approach
    p_TS: Array  # (m, 3) points spread evenly over the surface [m]
    n_TS: Array  # (m, 3) their outward normals
    center: Array  # (3,) of mass, in T [m]
    height: float  # of the object over the table [m]
    far_m: float  # distance from the centre at which no hand can touch the object


def make_site(
    surface: Surface, table: Plane, hand: HandModel, settings: PlannerSettings, seed: int
) -> Site:
    """Measure what every planner needs.

    Raises:
        BadInput: the surface is empty or open.
    """
    field = object_field(surface, table)
    X_WT = table_frame(table)
    p, n = sample_surface(TriMesh(surface.vertices, surface.faces), _SAMPLES, seed=seed)
    p_TS = (p - X_WT[:3, 3]) @ X_WT[:3, :3]
    center = (field.center - X_WT[:3, 3]) @ X_WT[:3, :3]
    reach = float(np.linalg.norm(hand.spheres(hand.lower)[0], axis=1).max())
    return Site(
        hand=hand,
        field=field,
        settings=settings,
        X_WT=X_WT,
        motions={name: motion_of(name, hand, settings.collect) for name in settings.approaches},
        p_TS=p_TS,
        n_TS=n @ X_WT[:3, :3],
        center=center,
        height=float(table.height(surface.vertices).max()),
        far_m=float(np.linalg.norm(p_TS - center, axis=1).max()) + reach + 0.03,
    )


def table_frame(table: Plane) -> Array:
    """X_WT (4, 4); the rotation is the identity for a level table."""
    up = np.asarray(table.normal, np.float64)
    X = np.eye(4)
    X[:3, :3] = Rotation.align_vectors(up[None], [_UP])[0].as_matrix()
    X[:3, 3] = table.offset * up
    return X


def collect_poses(
    site: Site, heading: Array, at: Array, lateral: Array, rng: np.random.Generator
) -> Array:
    """Free start poses (k, 4, 4) of the collecting grasp, k ≤ n.

    Args:
        site: object and hand.
        heading: (n,) of the fingers, about the table's normal [rad].
        at: (n, 3) places of the object in whose slices it is taken [m].
        lateral: (n,) position of the grasp to the left of the fingers [m].
        rng: draws the offsets.
    """
    s = site.settings
    if site.height > s.collect_tallest_m:
        return np.zeros((0, 4, 4))
    forward = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(len(heading))])
    left = np.cross(_UP, forward)
    middle, width = across_slice(site.p_TS, forward, left, at)
    along = middle + _between(s.collect_along_m, len(heading), rng)
    across = lateral + _between(s.collect_across_m, len(heading), rng)
    X = _turned_about_z(collect_pose(site.hand, site.hand.lower, s.collect), heading)
    X[:, :2, 3] += (along[:, None] * forward + across[:, None] * left)[:, :2]
    fits = (width >= s.least_width_m) & (width <= s.collect_widest_m)
    return _lifted(site, "collect", X[fits], s.collect_highest_m)


def side_poses(site: Site, facing: Array, at: Array, rng: np.random.Generator) -> Array:
    """Free start poses (k, 4, 4) of the grasp from the side, k ≤ n.

    Args:
        site: object and hand.
        facing: (n, 3) level unit vectors, out of the palm.
        at: (n, 3) places of the object in whose slices it is taken [m].
        rng: draws tilts and offsets.
    """
    s = site.settings
    if site.height < s.side_lowest_m or len(facing) == 0:
        return np.zeros((0, 4, 4))
    tilt = np.deg2rad(_between(s.side_tilts_deg, len(facing), rng))[:, None]
    fingers = np.cos(tilt) * np.cross(facing, _UP) - np.sin(tilt) * _UP
    thumb = np.cross(fingers, facing)
    at_height = np.column_stack([at[:, :2], _side_heights(at[:, 2], site)])
    middle, width = across_slice(site.p_TS, fingers, thumb, at_height)
    along = middle + _between(s.side_along_m, len(facing), rng)
    far = (site.center * facing).sum(axis=1) - site.far_m
    along_H, palm_H = hand_axes(site.hand)
    X = _aligned(along_H, palm_H, fingers, facing)
    tcp = X[:, :3, :3] @ np.asarray(site.hand.description.tcps["power"])
    # Across the fingers it is the hand's own middle, not the TCP's.
    tcp -= (tcp * thumb).sum(axis=1, keepdims=True) * thumb
    across = (at_height * thumb).sum(axis=1, keepdims=True)
    X[:, :3, 3] = along[:, None] * fingers + far[:, None] * facing + across * thumb - tcp
    fits = (width >= s.least_width_m) & (width <= s.side_widest_m)
    return _brought_near(site, "side", X[fits], palm_H)


def free_poses(site: Site, approach: Array, closing: Array, at: Array) -> Array:
    """Free start poses (k, 4, 4) of hands that come from anywhere, k ≤ n.

    The hand comes along its approach direction until it touches, and backs off.

    Args:
        site: object and hand.
        approach: (n, 3) unit vectors of the hand's way.
        closing: (n, 3) unit vectors across it, along which the fingers close on the thumb.
        at: (n, 3) places on which the power TCP aims [m].
    """
    s = site.settings
    slice_ = np.cross(approach, closing)
    middle, width = across_slice(site.p_TS, closing, slice_, at)
    approach_H, closing_H = approach_axes(site.hand)
    X = _aligned(approach_H, closing_H, approach, closing)
    tcp = X[:, :3, :3] @ np.asarray(site.hand.description.tcps["power"])
    aim = at + (middle - (at * closing).sum(axis=1))[:, None] * closing
    back = ((aim - site.center) * approach).sum(axis=1) + site.far_m
    X[:, :3, 3] = aim - back[:, None] * approach - tcp
    fits = (width >= s.least_width_m) & (width <= s.free_widest_m)
    near = _brought_near(site, "free", X[fits], approach_H)
    return _lifted(site, "free", np.linalg.inv(site.X_WT) @ near, 0.0)


def approach_axes(hand: HandModel) -> tuple[Array, Array]:
    """Unit vectors of the approach and, across it, of the fingers' closing on the thumb, in H."""
    along, palm = hand_axes(hand)
    across = np.cross(along, palm)
    approach = np.asarray(hand.description.approach, np.float64)
    approach = approach - (approach @ across) * across
    approach /= np.linalg.norm(approach)
    return approach, np.cross(across, approach)


def across_slice(points: Array, along: Array, slice_: Array, at: Array) -> tuple[Array, Array]:
    """Middle and width (n,) of points (m, 3) along directions, in slices through places `at`.

    The width is infinite where a slice holds no point.
    """
    positions = points @ along.T
    offsets = points @ slice_.T - (at * slice_).sum(axis=1)
    outside = np.abs(offsets) > _BAND_M
    low = np.where(outside, np.inf, positions).min(axis=0)
    high = np.where(outside, -np.inf, positions).max(axis=0)
    empty = low > high
    with np.errstate(invalid="ignore"):
        middle, width = (low + high) / 2, high - low
    return np.where(empty, 0.0, middle), np.where(empty, np.inf, width)


def _lifted(site: Site, approach: str, X_TH: Array, highest_m: float) -> Array:
    """Poses in the world, raised until they are free; those that never are drop out."""
    X_WH = site.X_WT @ X_TH
    lift = free_lift(site.hand, site.field, site.motions[approach], X_WH, highest_m=highest_m)
    X_WH[:, :3, 3] += np.nan_to_num(lift)[:, None] * site.X_WT[:3, 2]
    free: Array = X_WH[np.isfinite(lift)]
    return free


def _brought_near(site: Site, approach: str, X_TH: Array, direction: Array) -> Array:
    """Poses moved along a direction (3,) in H until just before contact; others drop out."""
    X_WH = site.X_WT @ X_TH
    way = way_to_contact(
        site.hand,
        site.field,
        site.motions[approach],
        X_WH,
        direction=direction,
        farthest_m=2 * site.far_m,
    )
    met = np.isfinite(way)
    near: Array = X_WH[met]
    near[:, :3, 3] += (way[met] - site.settings.clearance_m)[:, None] * (
        near[:, :3, :3] @ direction
    )
    return near


def _between(bounds: list[float], count: int, rng: np.random.Generator) -> Array:
    low, high = bounds
    return rng.uniform(low, high, count)


def _side_heights(heights: Array, site: Site) -> Array:
    """Heights of the hand's middle over the table [m]; the table comes first."""
    s, center = site.settings, float(site.center[2])
    low, high = s.side_heights_m
    wanted = np.clip(heights, center - s.side_near_center_m, center + s.side_near_center_m)
    highest = min(max(high, center), site.height - s.side_below_top_m)
    result: Array = np.maximum(np.minimum(wanted, highest), low)
    return result


def _aligned(one_H: Array, other_H: Array, one: Array, other: Array) -> Array:
    """Poses (n, 4, 4) at the origin that turn two orthogonal axes (3,) of H to (n, 3) given."""
    R_H = np.stack([one_H, other_H, np.cross(one_H, other_H)])
    X = np.tile(np.eye(4), (len(one), 1, 1))
    X[:, :3, :3] = np.stack([one, other, np.cross(one, other)], axis=2) @ R_H
    return X


def _turned_about_z(X: Array, heading: Array) -> Array:
    turns = np.tile(np.eye(4), (len(heading), 1, 1))
    turns[:, :3, :3] = Rotation.from_rotvec(heading[:, None] * _UP).as_matrix()
    turned: Array = turns @ X
    return turned
