"""How an object comes to rest on a table, and drawing such poses."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from vh_drake.geometry.inertia import mass_properties
from vh_drake.geometry.meshes import TriMesh
from vh_drake.types import Array, IntArray

_SAME_REST_RAD = np.deg2rad(20.0)  # neighbouring rests that differ less are one
_LEAST_PROBABILITY = 0.02
_SAME_FACET_RAD = np.deg2rad(0.2)
_TOLERANCE_M = 1e-9
_BARRIER_M = 2e-4  # an edge that lifts the centre of mass by less does not hold the object
_DOUBLINGS = 14  # of the number of rolls that are followed


@dataclass(frozen=True, eq=False)
class Rest:
    """A face of the convex hull that the object rests on."""

    X_WO: Array  # (4, 4) object on the plane z = 0, centre of mass over the origin
    probability: float  # that a random orientation rolls here
    group: int  # rests of like orientation share a number


def stable_poses(mesh: TriMesh) -> tuple[Rest, ...]:
    """Resting poses on a plane by quasi-static rolling (Goldberg et al. 1999).

    A random orientation lands on the hull face that the centre of mass sees below; where the
    centre of mass is not above that face, or hardly has to rise to pass an edge, the object
    rolls on as long as that lets it down, until it rests. Faces in one plane count as one
    rest. Rests that differ by less than 20 degrees, like those around the side of a can, form
    a group.

    Args:
        mesh: Watertight, of uniform density.
    """
    hull = mesh.convex_hull
    com = mass_properties(mesh, 1.0).com
    share = _solid_angles(hull.triangles - com) / (4 * np.pi)
    landed = np.bincount(_roll(hull, com), weights=share, minlength=len(hull.faces))
    rests = np.flatnonzero(landed > 0)
    facets = _linked(hull.face_normals[rests], _SAME_FACET_RAD)
    likeliest = [rests[facets == i][landed[rests[facets == i]].argmax()] for i in np.unique(facets)]
    downward = hull.face_normals[likeliest]
    probability = np.bincount(facets, weights=landed[rests])
    groups = _linked(downward, _SAME_REST_RAD)
    return tuple(
        Rest(_pose(mesh, com, normal), float(p), int(group))
        for normal, p, group in zip(downward, probability, groups, strict=True)
    )


def draw_pose(mesh: TriMesh, *, seed: int) -> Array:
    """Draw a resting pose X_WO (4, 4): lowest point at z = 0, centre of mass over the origin.

    The rest is drawn by its probability, among groups of at least 2 percent, the yaw
    uniformly from 0 to 360 degrees.

    Args:
        mesh: Watertight, of uniform density.
        seed: The same seed gives the same pose.
    """
    rng = np.random.default_rng(seed)
    rests = stable_poses(mesh)
    in_group = np.bincount([r.group for r in rests], weights=[r.probability for r in rests])
    weights = np.array([r.probability * (in_group[r.group] >= _LEAST_PROBABILITY) for r in rests])
    rest = rests[rng.choice(len(rests), p=weights / weights.sum())]
    X = np.eye(4)
    X[:3, :3] = Rotation.from_euler("z", rng.uniform(0.0, 2 * np.pi)).as_matrix()
    pose: Array = X @ rest.X_WO
    return pose


def _solid_angles(corners: Array) -> Array:
    """Solid angle of each triangle (f, 3, 3) from the origin (Van Oosterom & Strackee 1983)."""
    a, b, c = corners.swapaxes(0, 1)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    numerator = np.einsum("fi,fi->f", a, np.cross(b, c))
    dots = [np.einsum("fi,fi->f", u, v) for u, v in ((a, b), (b, c), (c, a))]
    denominator = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    angles: Array = 2 * np.arctan2(np.abs(numerator), denominator)
    return angles


def _roll(hull: TriMesh, com: Array) -> IntArray:
    """The face on which a body that lands on each face comes to rest, (f,)."""
    corners = hull.triangles
    edges = np.roll(corners, -1, axis=1) - corners  # (f, 3, 3)
    inward = np.cross(hull.face_normals[:, None], edges)
    inward /= np.maximum(np.linalg.norm(inward, axis=2, keepdims=True), 1e-300)
    margin = np.einsum("fei,fei->fe", com - corners, inward)  # below zero: beyond this edge
    height = np.einsum("fi,fi->f", corners[:, 0] - com, hull.face_normals)
    rise = np.hypot(height[:, None], margin) - height[:, None]
    open_edge = (margin < 0) | (rise < _BARRIER_M)
    neighbors = _neighbors(hull)
    beyond = np.where(open_edge, height[neighbors], np.inf)
    lowest = neighbors[np.arange(len(beyond)), beyond.argmin(axis=1)]
    coplanar = neighbors[np.arange(len(margin)), margin.argmin(axis=1)]
    here = np.arange(len(margin))
    inside = np.where(margin.min(axis=1) < -_TOLERANCE_M, coplanar, here)
    target = np.where(beyond.min(axis=1) < height - _TOLERANCE_M, lowest, inside)
    for _ in range(_DOUBLINGS):
        target = target[target]
    return target


def _neighbors(hull: TriMesh) -> IntArray:
    """The face across each edge of each face, (f, 3)."""
    weights = np.array([len(hull.vertices), 1])
    keys = hull.directed_edges @ weights
    order = np.argsort(keys)
    places = np.searchsorted(keys, hull.directed_edges[:, ::-1] @ weights, sorter=order)
    neighbors: IntArray = (order[places] // 3).reshape(-1, 3)
    return neighbors


def _linked(normals: Array, angle: float) -> IntArray:
    """Numbers of the chains of unit vectors (n, 3) in which each link is below an angle, (n,)."""
    pairs = cKDTree(normals).query_pairs(2 * np.sin(angle / 2), output_type="ndarray")
    n = len(normals)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    labels: IntArray = connected_components(graph, directed=False)[1].astype(np.int64)
    return labels


def _pose(mesh: TriMesh, com: Array, downward: Array) -> Array:
    """Object pose by the least turn of a direction down, lowest point at z = 0, (4, 4)."""
    x, y, z = downward
    tilt = np.array([-y, x, 0.0])  # axis times sine of the turn from downward to -z
    half = 1 - z  # 1 + cosine of it
    turn = Rotation.from_quat([*tilt, half] if half > 1e-9 else [1.0, 0.0, 0.0, 0.0])
    X = np.eye(4)
    X[:3, :3] = turn.as_matrix()
    X[:3, 3] = -X[:3, :3] @ com
    X[2, 3] = -(mesh.vertices @ X[2, :3]).min()
    return X
