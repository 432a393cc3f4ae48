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


def segment(cloud: Cloud, settings: SegmentationSettings | None = None) -> ObjectView:
    """The points of the object on the table, with normals.

    Args:
        cloud: what the camera saw; NaN and infinite points are ignored.
        settings: the knobs.

    Returns:
        Object points, outward normals, table plane and optical centre, in W.

    Raises:
        NothingSeen: no finite point in the workspace, no table, no object on it, or the
            object reaches beyond the view or the workspace.
    """
    settings = settings or SegmentationSettings()
    seen = _corrected(_seen(cloud, settings), settings)
    raised = seen.p_W[seen.table.height(seen.p_W) > _threshold(settings, seen.noise_m)]
    p_WO = _choose(raised, seen.table, settings)
    _check_view(p_WO, seen.cloud, settings)
    p_WO = voxel_downsample(p_WO, settings.voxel_m)
    p_WO = smooth(p_WO, local_planes(p_WO, radius_m=settings.normal_radius_m), seen.noise_m)
    # Noise spreads a surface over several layers of cells; now it fits into one.
    p_WO = voxel_downsample(p_WO, settings.voxel_m)
    normals = local_planes(p_WO, radius_m=settings.normal_radius_m).normal
    p_WCamera = seen.cloud.p_WCamera
    view = ObjectView(p_WO, towards(normals, p_WO, p_WCamera), seen.table, p_WCamera)
    if seen.error is None:
        return view
    left = left_covariance(seen.error, seen.table, p_WCamera, p_WO.mean(axis=0))
    return dc.replace(view, shift_covariance=left)


@dc.dataclass(frozen=True, eq=False)
class _Seen:
    """A cloud and the table in it."""

    cloud: Cloud
    p_W: Array  # (n, 3) in the workspace [m]
    table: Plane
    noise_m: float  # standard deviation of the table's points about it
    error: TableError | None = None  # of the camera's pose, which was corrected


def _seen(cloud: Cloud, settings: SegmentationSettings) -> _Seen:
    p_W = _in_workspace(cloud, settings)
    table, noise_m = fit_table(
        p_W,
        np.random.default_rng(settings.seed),
        inlier_m=settings.table_inlier_m,
        min_share=settings.min_table_share,
    )
    return _Seen(cloud, p_W, table, noise_m)


def _corrected(seen: _Seen, settings: SegmentationSettings) -> _Seen:
    """With the table where it is known to be, unless noise explains where it is seen."""
    if settings.known_height_m is None:
        return seen
    known = Plane(offset=settings.known_height_m)
    error = table_error(seen.table, known, seen.cloud.p_WCamera)
    tilted = error.tilt_rad > np.deg2rad(settings.least_tilt_deg)
    if not tilted and abs(error.rise_m) <= settings.least_rise_m:
        return seen
    cloud = corrected(seen.cloud, error, known)
    return _Seen(cloud, _in_workspace(cloud, settings), known, seen.noise_m, error)


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
