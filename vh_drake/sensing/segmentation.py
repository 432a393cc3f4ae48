"""From a cloud to the one object on the table (thesis, section 4.2)."""

import dataclasses as dc

import numpy as np
from numpy.typing import NDArray

from vh_drake.errors import NothingSeen
from vh_drake.sensing.camera_correction import TableError, corrected, left_covariance, table_error
from vh_drake.sensing.cloud_filters import (
    Clusters,
    cluster,
    local_planes,
    smooth,
    towards,
    voxel_downsample,
)
from vh_drake.sensing.table_plane import fit_table
from vh_drake.types import Array, Cloud, ObjectView, Plane


@dc.dataclass
class SegmentationSettings:
    """Where to look, and what counts as table, object and noise."""

    # Box in W that holds the object and a good part of the table [m].
    workspace_min: list[float] = dc.field(default_factory=lambda: [0.42, -0.75, 0.80])
    workspace_max: list[float] = dc.field(default_factory=lambda: [1.10, 0.15, 1.35])
    # Where the object is expected [m]; empty: the cluster with the most points is taken.
    expected_place: list[float] = dc.field(default_factory=list)
    seed: int = 0  # of the plane search
    # Of a level table in W; the camera's pose is corrected so that it is seen there [m].
    known_height_m: float | None = None
    # What noise may feign of an error of the camera's pose.
    least_tilt_deg: float = 0.25
    least_rise_m: float = 0.002
    table_inlier_m: float = 0.006  # distance of the table's points from its plane [m]
    min_table_share: float = 0.15  # share of the workspace's points on the table
    min_height_m: float = 0.004  # lower points are table [m] ...
    min_height_sigma: float = 2.5  # ... and so is what is below so many deviations of it
    cluster_cell_m: float = 0.01  # gaps up to twice of it are bridged [m]
    min_cell_points: int = 4  # sparser cells are outliers
    min_object_points: int = 60  # fewer are no object
    max_gap_m: float = 0.05  # what floats higher above the table is no object [m]
    voxel_m: float = 0.003  # spacing of the result [m]
    normal_radius_m: float = 0.010  # neighbourhood of a normal [m]
    border_deg: float = 0.3  # points nearer to the view's border may go on beyond it
    max_border_share: float = 0.01  # share of such points that means: cut off


def segment(
    cloud: Cloud, settings: SegmentationSettings | None = None, table: Plane | None = None
) -> ObjectView:
    """The points of the object on the table, with normals.

    Args:
        cloud: what the camera saw; NaN and infinite points are ignored.
        settings: the knobs.
        table: the table's plane, where it is known; else the largest horizontal plane.

    Returns:
        Object points, outward normals, table plane and optical centre, in W.

    Raises:
        NothingSeen: no finite point in the workspace, no table, no object on it, or the
            object reaches beyond the view or the workspace.
    """
    settings = settings or SegmentationSettings()
    p_W = _in_workspace(cloud, settings)
    table, noise_m = _table(p_W, settings, table)
    error = _table_error(table, cloud, settings)
    if error is not None:
        table = _known_table(settings)
        cloud = corrected(cloud, error, table)
        p_W = _in_workspace(cloud, settings)
    raised = p_W[table.height(p_W) > _threshold(settings, noise_m)]
    p_WO = _choose(raised, table, settings)
    _check_view(p_WO, cloud, settings)
    p_WO = voxel_downsample(p_WO, settings.voxel_m)
    p_WO = smooth(p_WO, local_planes(p_WO, radius_m=settings.normal_radius_m), noise_m)
    # Noise spreads a surface over several layers of cells; now it fits into one.
    p_WO = voxel_downsample(p_WO, settings.voxel_m)
    normals = local_planes(p_WO, radius_m=settings.normal_radius_m).normal
    n_WO = towards(normals, p_WO, cloud.p_WCamera)
    view = ObjectView(p_WO, n_WO, table, cloud.p_WCamera)
    if error is None:
        return view
    left = left_covariance(error, table, cloud.p_WCamera, p_WO.mean(axis=0))
    return dc.replace(view, shift_covariance=left)


def _known_table(settings: SegmentationSettings) -> Plane:
    return Plane(offset=settings.known_height_m or 0.0)


def _table_error(table: Plane, cloud: Cloud, settings: SegmentationSettings) -> TableError | None:
    """How the seen table differs from the known one; None where noise explains it."""
    if settings.known_height_m is None:
        return None
    error = table_error(table, _known_table(settings), cloud.p_WCamera)
    tilted = error.tilt_rad > np.deg2rad(settings.least_tilt_deg)
    return error if tilted or abs(error.rise_m) > settings.least_rise_m else None


def _threshold(settings: SegmentationSettings, noise_m: float) -> float:
    return max(settings.min_height_m, settings.min_height_sigma * noise_m)


def _in_workspace(cloud: Cloud, settings: SegmentationSettings) -> Array:
    low, high = np.array(settings.workspace_min), np.array(settings.workspace_max)
    with np.errstate(invalid="ignore"):
        inside = ((cloud.p_WC >= low) & (cloud.p_WC <= high)).all(axis=1)
    p_W = cloud.p_WC[inside]
    if len(p_W) < settings.min_object_points:
        finite = int(np.isfinite(cloud.p_WC).all(axis=1).sum())
        raise NothingSeen(
            f"{len(p_W)} of {len(cloud.p_WC)} points ({finite} finite) lie in the workspace "
            f"{settings.workspace_min} to {settings.workspace_max} m; point the camera at the "
            "table, check its pose and units, or widen the workspace"
        )
    return p_W


def _table(p_W: Array, settings: SegmentationSettings, table: Plane | None) -> tuple[Plane, float]:
    """The plane and the standard deviation [m] of the points about it."""
    if table is not None:
        near = np.abs(table.height(p_W))
        near = near[near < settings.table_inlier_m]
        return table, float(1.4826 * np.median(near)) if len(near) else 0.0
    return fit_table(
        p_W,
        np.random.default_rng(settings.seed),
        inlier_m=settings.table_inlier_m,
        min_share=settings.min_table_share,
    )


def _choose(raised: Array, table: Plane, settings: SegmentationSettings) -> Array:
    """The points of the object's cluster."""
    clusters = cluster(raised, cell_m=settings.cluster_cell_m, min_points=settings.min_cell_points)
    sizes = np.bincount(clusters.label[clusters.label >= 0], minlength=clusters.number)
    best, rating, cut = -1, -np.inf, 0
    for label in np.flatnonzero(sizes >= settings.min_object_points):
        points = raised[clusters.label == label]
        if table.height(points).min() > settings.max_gap_m:
            continue
        if _leaves(points, settings):
            cut = max(cut, len(points))
            continue
        value = _rate(points, settings)
        if value > rating:
            best, rating = int(label), value
    if best < 0:
        raise NothingSeen(_no_object(raised, clusters, cut, settings))
    p_WO: Array = raised[clusters.label == best]
    return p_WO


def _rate(points: Array, settings: SegmentationSettings) -> float:
    """Higher is more likely the object: near the expected place, else many points."""
    if settings.expected_place:
        offset = np.median(points, axis=0) - np.array(settings.expected_place)
        return -float(np.hypot(offset[0], offset[1]))
    return float(len(points))


def _leaves(points: Array, settings: SegmentationSettings) -> bool:
    """Whether a cluster goes on outside the workspace, as the robot's arm does."""
    margin = settings.voxel_m
    low = points.min(axis=0) < np.array(settings.workspace_min) + margin
    high = points.max(axis=0) > np.array(settings.workspace_max) - margin
    return bool(low[:2].any() or high.any())


def _no_object(raised: Array, clusters: Clusters, cut: int, settings: SegmentationSettings) -> str:
    if cut:
        return (
            f"the only thing on the table ({cut} points) reaches out of the workspace "
            f"{settings.workspace_min} to {settings.workspace_max} m; move it to the middle, "
            "or widen the workspace"
        )
    return (
        f"no object on the table: {len(raised)} points above it in {clusters.number} clusters, "
        f"none with {settings.min_object_points} points that stands on it; put the object into "
        "the camera's view"
    )


def _check_view(p_WO: Array, cloud: Cloud, settings: SegmentationSettings) -> None:
    """Refuses an object that the image cuts off; needs a cloud that knows its view."""
    if len(cloud.n_WFrustum) == 0:
        return
    ray = p_WO - cloud.p_WCamera
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    near: NDArray[np.bool_] = (ray @ cloud.n_WFrustum.T).min(axis=1) < np.sin(
        np.deg2rad(settings.border_deg)
    )
    if near.mean() > settings.max_border_share:
        raise NothingSeen(
            f"the object is out of view: {int(near.sum())} of its {len(p_WO)} points lie at the "
            "border of the image; turn the camera or move the object to the middle"
        )
