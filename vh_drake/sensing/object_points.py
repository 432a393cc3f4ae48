"""A cloud that holds one object alone, on a table that is known otherwise."""

from vh_drake.errors import NothingSeen
from vh_drake.sensing.cloud_filters import local_planes, towards, voxel_downsample
from vh_drake.sensing.segmentation import SegmentationSettings
from vh_drake.types import Cloud, ObjectView, Plane


def object_points(
    cloud: Cloud, table: Plane, settings: SegmentationSettings | None = None
) -> ObjectView:
    """The points over the table with normals; nothing is cut out and nothing smoothed.

    Args:
        cloud: finite points of the object [m]; what lies on or below the table is dropped.
        table: the plane.
        settings: heights, spacing and neighbourhoods, as in `segment`.

    Returns:
        Object points, outward normals, table plane and optical centre, in W.

    Raises:
        NothingSeen: too few points over the table.
    """
    settings = settings or SegmentationSettings()
    height = table.height(cloud.p_WC)
    p_WO = cloud.p_WC[height > settings.min_height_m]
    if len(p_WO) < settings.min_object_points:
        low, high = (height.min(), height.max()) if len(height) else (0.0, 0.0)
        raise NothingSeen(
            f"{len(p_WO)} of {len(cloud.p_WC)} points lie over the table, "
            f"{settings.min_object_points} are needed; the points are {low:.3f} to {high:.3f} m "
            "over it: check the plane, the frame and the units"
        )
    p_WO = voxel_downsample(p_WO, settings.voxel_m)
    normals = local_planes(p_WO, radius_m=settings.normal_radius_m).normal
    return ObjectView(p_WO, towards(normals, p_WO, cloud.p_WCamera), table, cloud.p_WCamera)
