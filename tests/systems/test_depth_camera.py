import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.sensors import ImageDepth32F

from vh_drake.errors import BadInput
from vh_drake.sensing.depth_noise import DepthNoiseSettings
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.point_cloud import cloud_from_depth
from vh_drake.systems.depth_camera import DepthCamera

PINHOLE = Intrinsics.from_fov(64, 48, 0.8)
X_WC = RigidTransform(RollPitchYaw(2.4, 0.1, -1.5), [0.2, 0.0, 1.8])
SILENT = DepthNoiseSettings(axial_m=0.0, axial_per_m=0.0, grazing=0.0, disparity_step_px=0.0)


def image(depth_m: float) -> Value:
    picture = ImageDepth32F(64, 48)
    picture.mutable_data[:] = depth_m
    picture.mutable_data[0, :5] = np.inf
    return Value(picture)


def context_at(camera: DepthCamera, time_s: float = 0.0, depth_m: float = 1.0):
    context = camera.CreateDefaultContext()
    context.SetTime(time_s)
    camera.GetInputPort("depth_image").FixValue(context, image(depth_m))
    camera.GetInputPort("X_WC").FixValue(context, Value(X_WC))
    return context


def cloud(camera, context):
    return camera.GetOutputPort("cloud").Eval(context)


def depth(camera, context):
    return camera.GetOutputPort("depth_image").Eval(context).data[:, :, 0].copy()


def test_without_noise_the_cloud_is_the_back_projected_image():
    camera = DepthCamera(PINHOLE, SILENT)
    context = context_at(camera)
    perfect = depth(camera, context)
    expected = cloud_from_depth(perfect, PINHOLE, X_WC.GetAsMatrix4())
    np.testing.assert_allclose(cloud(camera, context).p_WC, expected.p_WC)
    np.testing.assert_allclose(perfect[10:], 1.0)
    assert not perfect[0, :4].any()


def test_noise_depends_on_seed_and_time_alone():
    camera = DepthCamera(PINHOLE, seed=1)
    first, again = context_at(camera, 0.5), context_at(camera, 0.5)
    again.DisableCaching()
    np.testing.assert_array_equal(depth(camera, first), depth(camera, again))
    np.testing.assert_array_equal(cloud(camera, first).p_WC, cloud(camera, again).p_WC)
    later, other = context_at(camera, 0.6), DepthCamera(PINHOLE, seed=2)
    assert not np.array_equal(depth(camera, first), depth(camera, later))
    assert not np.array_equal(depth(camera, first), depth(other, context_at(other, 0.5)))


def test_two_contexts_do_not_touch_each_other():
    camera = DepthCamera(PINHOLE, SILENT)
    near, far = context_at(camera, depth_m=1.0), context_at(camera, depth_m=2.0)
    before = cloud(camera, near).p_WC.copy()
    assert depth(camera, far)[20, 20] == pytest.approx(2.0)
    np.testing.assert_array_equal(cloud(camera, near).p_WC, before)


def test_an_image_without_any_measurement_gives_an_empty_cloud():
    camera = DepthCamera(PINHOLE)
    assert cloud(camera, context_at(camera, depth_m=np.nan)).p_WC.shape == (0, 3)


def test_an_image_of_another_size_is_refused():
    camera = DepthCamera(Intrinsics.from_fov(32, 24, 0.8))
    with pytest.raises(BadInput, match="48 x 64 pixels"):
        cloud(camera, context_at(camera))


def test_a_wrong_calibration_moves_the_whole_cloud():
    believed = RigidTransform(RollPitchYaw(0.02, -0.01, 0.03), [0.004, -0.002, 0.006])
    exact, wrong = (DepthCamera(PINHOLE, seed=1, X_CBelieved=X) for X in (None, believed))
    p, q = (cloud(camera, context_at(camera)) for camera in (exact, wrong))
    moved = X_WC @ believed @ X_WC.inverse()
    np.testing.assert_allclose(q.p_WC, (moved @ p.p_WC.T).T, atol=1e-6)
