"""Puts the depth camera into a diagram."""

import dataclasses as dc

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.geometry import (
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    FrameId,
    RenderCameraCore,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from vh_drake.scenes.rendering import add_rendered_copy
from vh_drake.sensing.depth_noise import DepthNoiseSettings
from vh_drake.sensing.egl import egl_available
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.systems.depth_camera import DepthCamera
from vh_drake.systems.raycast_depth import RaycastDepth

_RENDERER = "depth_camera"


@dc.dataclass
class CameraSettings:
    """The camera in the robot's head."""

    width: int = 640  # [pixel]
    height: int = 480  # [pixel]
    fov_y_rad: float = 0.7854  # vertical angle of view, a Carmine's 45 degrees [rad]
    min_depth_m: float = 0.3  # nearer surfaces are not measured [m]
    max_depth_m: float = 3.0  # nor are farther ones [m]
    noise: DepthNoiseSettings = dc.field(default_factory=DepthNoiseSettings)
    # Error of the hand-eye calibration; the seed draws its directions.
    calibration_shift_m: float = 0.0
    calibration_turn_deg: float = 0.0

    def believed_pose(self, seed: int) -> RigidTransform:
        """X_CBelieved: where the calibration puts the camera, in its true frame."""
        axes = np.random.default_rng([seed, 7]).standard_normal((2, 3))
        shift, axis = axes / np.linalg.norm(axes, axis=1, keepdims=True)
        turn = AngleAxis(np.deg2rad(self.calibration_turn_deg), axis)
        return RigidTransform(turn, self.calibration_shift_m * shift)

    def intrinsics(self) -> Intrinsics:
        """The pinhole of these settings."""
        return Intrinsics.from_fov(self.width, self.height, self.fov_y_rad)


def make_depth_camera(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    parent_frame_id: FrameId,
    X_PC: RigidTransform,
    settings: CameraSettings | None = None,
    seed: int = 0,
    *,
    render: bool | None = None,
) -> DepthCamera:
    """Adds a depth source and a `DepthCamera`, and wires them.

    Args:
        builder: takes the systems.
        scene_graph: already in the builder, with all geometry that shall be seen.
        parent_frame_id: frame that carries the camera.
        X_PC: optical frame (+z forward, +x right, +y down) in it.
        settings: of the camera.
        seed: of the noise.
        render: True renders with VTK and EGL, False casts rays on the CPU, None renders
            where EGL works.

    Returns:
        The camera, with the outputs `depth_image` and `cloud`.

    Raises:
        BadInput: the image is empty or the angle of view lies outside (0, pi).
    """
    settings = settings or CameraSettings()
    intrinsics = settings.intrinsics()
    render = egl_available() if render is None else render
    make = _add_rendered if render else _add_cast
    source = make(builder, scene_graph, parent_frame_id, X_PC, settings)
    believed = settings.believed_pose(seed)
    camera = builder.AddNamedSystem(
        "depth_camera", DepthCamera(intrinsics, settings.noise, seed, believed)
    )
    builder.Connect(source.GetOutputPort("depth_image_32f"), camera.GetInputPort("depth_image"))
    builder.Connect(source.GetOutputPort("body_pose_in_world"), camera.GetInputPort("X_WC"))
    return camera


def _add_rendered(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    parent: FrameId,
    X_PC: RigidTransform,
    settings: CameraSettings,
) -> RgbdSensor:
    pinhole = settings.intrinsics()
    # Drake's renderer counts from the image's corner, we from the first pixel's middle.
    centre = pinhole.cx + 0.5, pinhole.cy + 0.5
    info = CameraInfo(pinhole.width, pinhole.height, pinhole.fx, pinhole.fy, *centre)
    clipping = ClippingRange(0.5 * settings.min_depth_m, 2.0 * settings.max_depth_m)
    core = RenderCameraCore(_RENDERER, info, clipping, RigidTransform())
    depth_range = DepthRange(settings.min_depth_m, settings.max_depth_m)
    copy, frames = add_rendered_copy(builder, scene_graph, _RENDERER)
    sensor = RgbdSensor(frames[parent], X_PC, DepthRenderCamera(core, depth_range))
    builder.AddNamedSystem("depth_source", sensor)
    builder.Connect(copy.get_query_output_port(), sensor.GetInputPort("geometry_query"))
    return sensor


def _add_cast(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    parent: FrameId,
    X_PC: RigidTransform,
    settings: CameraSettings,
) -> LeafSystem:
    caster = RaycastDepth(
        parent,
        X_PC,
        settings.intrinsics(),
        min_depth_m=settings.min_depth_m,
        max_depth_m=settings.max_depth_m,
    )
    builder.AddNamedSystem("depth_source", caster)
    builder.Connect(scene_graph.get_query_output_port(), caster.GetInputPort("geometry_query"))
    return caster
