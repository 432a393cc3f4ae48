"""Grasp candidates from random places of an estimated surface.

A place on the surface, drawn by area, says where the hand goes and, by its normal, from
where; the two motions that the robot can execute say how. *collect* comes from the top with
the line from fingertips to thumb parallel to the table; the fingers close along a horizontal
normal, or along a random heading. *side* faces the normal with its palm, thumb up, and takes
objects that are too tall for *collect*.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import TriMesh
from vh_drake.grasping.diversity import spread
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.motions import (
    CollectSettings,
    MotionArrays,
    collect_motion,
    collect_pose,
    hand_axes,
    side_motion,
)
from vh_drake.grasping.placement import free_lift, way_to_contact
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Candidates, Plane, Surface

PLANNER = "surface"
_BAND_M = 0.025  # Half the width of the slice in which the object's width is taken


@dc.dataclass
class PlannerSettings:
    """What may be proposed; offsets as in the collecting and side grasps that held objects.

    Along is the direction of the fingers, across is to their left as seen from above; both
    count from the object to the power TCP, so that a negative `along` puts the object nearer
    to the fingertips.
    """

    candidates: int = 400
    rounds: int = 4  # of drawing places until enough candidates are free
    draws: int = 600  # places a round
    least_width_m: float = 0.02
    collect: CollectSettings = dc.field(default_factory=CollectSettings)
    collect_along_m: list[float] = dc.field(default_factory=lambda: [-0.05, -0.025])
    collect_across_m: list[float] = dc.field(default_factory=lambda: [-0.04, -0.015])
    collect_widest_m: float = 0.12
    collect_tallest_m: float = 0.13
    collect_highest_m: float = 0.03  # how far the hand may rise off its height to be free
    side_along_m: list[float] = dc.field(default_factory=lambda: [-0.06, -0.035])
    side_heights_m: list[float] = dc.field(default_factory=lambda: [0.05, 0.12])
    side_below_top_m: float = 0.05  # of the hand's middle; the thumb is above it
    side_near_center_m: float = 0.03  # of the hand's middle above or below the centre of mass
    side_widest_m: float = 0.11
    side_lowest_m: float = 0.09  # height of objects that are taken from the side
    side_clearance_m: float = 0.006  # between palm and object before closing


@dc.dataclass(frozen=True, eq=False)
class Places:
    """Points on an object in a frame whose z axis is the table's normal and z = 0 its top."""

    points: Array  # (n, 3) [m]
    normals: Array  # (n, 3) outward
    center: Array  # (3,) of mass
    height: float  # of the object


def plan_candidates(
    surface: Surface, table: Plane, hand: HandModel, settings: PlannerSettings, seed: int
) -> Candidates:
    """Candidates whose open hand is free of the estimate and the table; diverse, maybe none.

    Raises:
        BadInput: the surface is empty or open, or the settings ask for nothing.
    """
    if min(settings.candidates, settings.rounds, settings.draws) < 1:
        raise BadInput("planner settings: candidates, rounds and draws must be positive")
    field = object_field(surface, table)
    R_WT = table_rotation(table)
    rng = np.random.default_rng(seed)
    found: dict[str, list[Array]] = {"collect": [], "side": []}
    for _ in range(settings.rounds):
        places = draw_places(surface, field, R_WT, settings.draws, rng)
        found["collect"].append(collect_poses(places, field, R_WT, hand, settings, rng))
        found["side"].append(side_poses(places, field, R_WT, hand, settings, rng))
        if sum(map(len, found["collect"] + found["side"])) >= 2 * settings.candidates:
            break
    poses = np.vstack([*found["collect"], *found["side"]])
    motion = np.repeat(list(found), [sum(map(len, parts)) for parts in found.values()])
    kept = spread(poses, motion == "side", hand, settings.candidates)
    return Candidates(poses[kept], tuple(map(str, motion[kept])), (PLANNER,) * len(kept))


def table_rotation(table: Plane) -> Array:
    """Rotation (3, 3) from table axes, z up, to the world; the identity for a level table."""
    up = np.asarray(table.normal, np.float64)
    rotation: Array = Rotation.align_vectors(up[None], [[0.0, 0.0, 1.0]])[0].as_matrix()
    return rotation


def draw_places(
    surface: Surface, field: ObjectField, R_WT: Array, count: int, rng: np.random.Generator
) -> Places:
    """Places drawn evenly by area, in table axes."""
    mesh = TriMesh(surface.vertices, surface.faces)
    faces = rng.choice(len(mesh.faces), size=count, p=mesh.areas / mesh.areas.sum())
    u, v = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    points = np.einsum("nc,nci->ni", weights, mesh.triangles[faces])
    down = np.array([0.0, 0.0, field.table.offset])
    heights = field.table.height(surface.vertices)
    return Places(
        points=points @ R_WT - down,
        normals=mesh.face_normals[faces] @ R_WT,
        center=field.center @ R_WT - down,
        height=float(heights.max()),
    )


def collect_poses(
    places: Places,
    field: ObjectField,
    R_WT: Array,
    hand: HandModel,
    settings: PlannerSettings,
    rng: np.random.Generator,
) -> Array:
    """Free start poses (n, 4, 4) of the collecting grasp."""
    count = len(places.points)
    if places.height > settings.collect_tallest_m:
        return np.zeros((0, 4, 4))
    heading = _headings(places.normals, rng)
    forward = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(count)])
    left = np.column_stack([-forward[:, 1], forward[:, 0], np.zeros(count)])
    middle, width = _across_slice(places, forward, left, places.points)
    beside = ((places.points - places.center) * left).sum(axis=1) * rng.uniform(0, 0.7, count)
    across = _between(settings.collect_across_m, count, rng)
    along = _between(settings.collect_along_m, count, rng)
    target = (middle + along)[:, None] * forward
    target += ((places.center * left).sum(axis=1) + beside + across)[:, None] * left
    X = _turned_about_z(collect_pose(hand, hand.lower, settings.collect), heading)
    X[:, :2, 3] += target[:, :2]
    X = X[(width >= settings.least_width_m) & (width <= settings.collect_widest_m)]
    X_WH = _in_world(X, field, R_WT)
    motion = collect_motion(hand, settings.collect)
    lift = free_lift(hand, field, motion, X_WH, highest_m=settings.collect_highest_m)
    X_WH[:, :3, 3] += np.nan_to_num(lift)[:, None] * field.table.normal
    free: Array = X_WH[np.isfinite(lift)]
    return free


def side_poses(
    places: Places,
    field: ObjectField,
    R_WT: Array,
    hand: HandModel,
    settings: PlannerSettings,
    rng: np.random.Generator,
) -> Array:
    """Free start poses (n, 4, 4) of the grasp from the side."""
    if places.height < settings.side_lowest_m:
        return np.zeros((0, 4, 4))
    upright = np.abs(places.normals[:, 2]) < 0.5
    points, facing = places.points[upright], -places.normals[upright] * [1, 1, 0]
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    up = np.array([0.0, 0.0, 1.0])
    fingers = np.cross(facing, up)
    height = _side_heights(points[:, 2], places, settings)
    at_height = np.column_stack([points[:, :2], height])
    middle, width = _across_slice(places, fingers, np.broadcast_to(up, fingers.shape), at_height)
    fits = (width >= settings.least_width_m) & (width <= settings.side_widest_m)
    along = (middle + _between(settings.side_along_m, len(points), rng))[fits]
    facing, fingers, height = facing[fits], fingers[fits], height[fits]
    far = (places.center * facing).sum(axis=1) - _far(places, hand)
    X = _side_pose(hand, facing, fingers)
    X[:, :3, 3] += along[:, None] * fingers + far[:, None] * facing + height[:, None] * up
    X_WH = _in_world(X, field, R_WT)
    return _brought_near(X_WH, field, hand, side_motion(hand), places, settings)


def _brought_near(
    X_WH: Array,
    field: ObjectField,
    hand: HandModel,
    motion: MotionArrays,
    places: Places,
    settings: PlannerSettings,
) -> Array:
    """Poses moved out of the palm until just before contact; those that meet nothing drop out."""
    palm = hand_axes(hand)[1]
    farthest = 2 * _far(places, hand)
    way = way_to_contact(hand, field, motion, X_WH, direction=palm, farthest_m=farthest)
    met = np.isfinite(way)
    way = way[met] - settings.side_clearance_m
    near = X_WH[met].copy()
    near[:, :3, 3] += way[:, None] * (near[:, :3, :3] @ palm)
    return near


def _far(places: Places, hand: HandModel) -> float:
    """A distance at which no hand can touch the object [m]."""
    reach = np.linalg.norm(hand.spheres(hand.lower)[0], axis=1).max()
    return float(np.linalg.norm(places.points - places.center, axis=1).max() + reach + 0.03)


def _between(bounds: list[float], count: int, rng: np.random.Generator) -> Array:
    low, high = bounds
    return rng.uniform(low, high, count)


def _headings(normals: Array, rng: np.random.Generator) -> Array:
    """Headings [rad] of the fingers: along horizontal normals, fore or aft, else random."""
    count = len(normals)
    heading = np.arctan2(normals[:, 1], normals[:, 0]) + np.pi * rng.integers(0, 2, count)
    aligned = (np.abs(normals[:, 2]) < 0.5) & (rng.random(count) < 0.7)
    result: Array = np.where(aligned, heading, rng.uniform(-np.pi, np.pi, count))
    return result


def _side_heights(heights: Array, places: Places, settings: PlannerSettings) -> Array:
    """Heights of the hand's middle over the table [m]; the table comes first."""
    low, high = settings.side_heights_m
    near = settings.side_near_center_m
    wanted = np.clip(heights, places.center[2] - near, places.center[2] + near)
    highest = min(max(high, places.center[2]), places.height - settings.side_below_top_m)
    result: Array = np.maximum(np.minimum(wanted, highest), low)
    return result


def _across_slice(places: Places, along: Array, slice_: Array, at: Array) -> tuple[Array, Array]:
    """Middle and width (n,) of the object along directions, in slices through points `at`."""
    positions = places.points @ along.T
    offsets = places.points @ slice_.T - (at * slice_).sum(axis=1)
    outside = np.abs(offsets) > _BAND_M
    low = np.where(outside, np.inf, positions).min(axis=0)
    high = np.where(outside, -np.inf, positions).max(axis=0)
    empty = low > high
    width = np.where(empty, np.inf, high - low)
    return np.where(empty, 0.0, (low + high) / 2), width


def _side_pose(hand: HandModel, facing: Array, fingers: Array) -> Array:
    """Poses (n, 4, 4) with the palm facing, the fingers along, and the power TCP at the origin."""
    along, palm = hand_axes(hand)
    R_H = np.stack([along, palm, np.cross(along, palm)])
    axes = np.stack([fingers, facing, np.cross(fingers, facing)], axis=2)
    X = np.tile(np.eye(4), (len(facing), 1, 1))
    X[:, :3, :3] = axes @ R_H
    tcp = np.asarray(hand.description.tcps["power"])
    level = np.array([1.0, 1.0, 0.0])  # The height is the hand's own, not the TCP's.
    X[:, :3, 3] = -(X[:, :3, :3] @ tcp) * level
    return X


def _turned_about_z(X: Array, heading: Array) -> Array:
    turns = np.tile(np.eye(4), (len(heading), 1, 1))
    turns[:, :3, :3] = Rotation.from_rotvec(heading[:, None] * [0.0, 0.0, 1.0]).as_matrix()
    turned: Array = turns @ X
    return turned


def _in_world(X: Array, field: ObjectField, R_WT: Array) -> Array:
    X_WT = np.eye(4)
    X_WT[:3, :3] = R_WT
    X_WT[:3, 3] = field.table.offset * np.asarray(field.table.normal)
    poses: Array = X_WT @ X
    return poses
