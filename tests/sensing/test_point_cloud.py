import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.sensors import CameraInfo

from vh_drake.errors import BadInput
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.point_cloud import cloud_from_depth

CAMERA = Intrinsics.from_fov(40, 30, 0.8)
X_WC = RigidTransform(RollPitchYaw(0.3, -0.5, 1.1), [0.2, -0.4, 1.5]).GetAsMatrix4()


def test_focal_lengths_are_drake_s_and_the_middle_is_the_mean_pixel():
    info = CameraInfo(40, 30, 0.8)
    np.testing.assert_allclose((CAMERA.fx, CAMERA.fy), (info.focal_x(), info.focal_y()))
    np.testing.assert_allclose(CAMERA.rays().mean(axis=(0, 1)), [0.0, 0.0, 1.0], atol=1e-12)


def test_points_project_back_onto_their_pixels():
    depth = np.random.default_rng(0).uniform(0.5, 2.0, (30, 40))
    cloud = cloud_from_depth(depth, CAMERA, X_WC)
    p_C = (cloud.p_WC - X_WC[:3, 3]) @ X_WC[:3, :3]
    u, v = (
        p_C[:, 0] / p_C[:, 2] * CAMERA.fx + CAMERA.cx,
        p_C[:, 1] / p_C[:, 2] * CAMERA.fy + CAMERA.cy,
    )
    grid_v, grid_u = np.mgrid[:30, :40]
    np.testing.assert_allclose(u, grid_u.ravel(), atol=1e-9)
    np.testing.assert_allclose(v, grid_v.ravel(), atol=1e-9)
    np.testing.assert_allclose(p_C[:, 2], depth.ravel())


def test_pixels_that_measured_nothing_are_dropped():
    depth = np.ones((30, 40))
    depth[0, :4] = [0.0, np.inf, np.nan, -1.0]
    assert len(cloud_from_depth(depth, CAMERA, X_WC).p_WC) == 30 * 40 - 4


def test_every_point_lies_inside_the_frustum_and_border_pixels_touch_it():
    cloud = cloud_from_depth(np.ones((30, 40)), CAMERA, X_WC)
    distance = (cloud.p_WC - cloud.p_WCamera) @ cloud.n_WFrustum.T
    assert distance.min() > 0.0
    np.testing.assert_allclose(distance.min(axis=0), distance.min(), rtol=0.2)


def test_an_image_of_another_size_is_refused():
    with pytest.raises(BadInput, match="30 x 40 pixels"):
        cloud_from_depth(np.ones((40, 30)), CAMERA, X_WC)


@pytest.mark.parametrize(("size", "fov"), [((0, 30), 0.8), ((40, 30), 0.0), ((40, 30), 3.2)])
def test_a_camera_that_sees_nothing_is_refused(size, fov):
    with pytest.raises(BadInput, match="sees nothing"):
        Intrinsics.from_fov(*size, fov)
