import subprocess

import numpy as np
import pytest
from pydrake.geometry import (
    Box,
    Cylinder,
    GeometryInstance,
    PerceptionProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from vh_drake.errors import BadInput
from vh_drake.scenes.camera import CameraSettings, make_depth_camera
from vh_drake.sensing import egl
from vh_drake.sensing.depth_noise import DepthNoiseSettings
from vh_drake.sensing.segmentation import segment

SILENT = DepthNoiseSettings(
    axial_m=0.0, axial_per_m=0.0, grazing=0.0, disparity_step_px=0.0, lateral_px=0.0,
    edge_dropout=0.0, max_incidence_deg=90.0,
)  # fmt: skip
PITCH = np.deg2rad(50.0)
Z_C = np.array([np.cos(PITCH), 0.0, -np.sin(PITCH)])
X_C = np.array([0.0, -1.0, 0.0])
X_WC = RigidTransform(RotationMatrix(np.stack([X_C, np.cross(Z_C, X_C), Z_C], 1)), [0.21, 0, 1.82])


def scene(settings, *, render, seed=0, roll=0.0):
    """A can on a table before the robot's camera."""
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    source = scene_graph.RegisterSource("test")
    for shape, place in (
        (Box(0.6, 1.2, 0.04), [0.85, -0.2, 0.88]),
        (Cylinder(0.034, 0.1), [0.7, -0.3, 0.95]),
    ):
        instance = GeometryInstance(RigidTransform(place), shape, f"{place}")
        instance.set_perception_properties(PerceptionProperties())
        scene_graph.RegisterAnchoredGeometry(source, instance)
    frame = scene_graph.world_frame_id()
    X_PC = X_WC @ RigidTransform(RotationMatrix.MakeZRotation(roll), [0, 0, 0])
    camera = make_depth_camera(builder, scene_graph, frame, X_PC, settings, seed, render=render)
    diagram = builder.Build()
    return diagram, camera


def depth(settings, *, render, roll):
    diagram, camera = scene(settings, render=render, roll=roll)
    root = diagram.CreateDefaultContext()  # It owns the camera's context.
    context = camera.GetMyContextFromRoot(root)
    return camera.GetOutputPort("depth_image").Eval(context).data[:, :, 0].copy()


def test_rendering_and_ray_casting_see_the_same():
    settings = CameraSettings(width=320, height=240, noise=SILENT)
    for roll in (0.0, 0.8):  # A table seen askew tells rows and columns apart.
        rendered = depth(settings, render=True, roll=roll)
        cast = depth(settings, render=False, roll=roll)
        both = (rendered > 0.0) & (cast > 0.0)
        assert np.mean((rendered > 0.0) == (cast > 0.0)) > 0.995
        assert np.median(np.abs(rendered - cast)[both]) < 1e-5
        assert np.mean(np.abs(rendered - cast)[both] > 1e-3) < 0.01


@pytest.mark.parametrize("render", [None, False])
def test_the_can_is_segmented_from_the_camera_s_cloud(render):
    diagram, camera = scene(CameraSettings(), render=render)
    root = diagram.CreateDefaultContext()
    context = camera.GetMyContextFromRoot(root)
    seen = segment(camera.GetOutputPort("cloud").Eval(context))
    radius = np.linalg.norm(seen.p_WO[:, :2] - [0.7, -0.3], axis=1)
    assert len(seen.p_WO) > 500
    assert radius.max() < 0.04
    assert seen.p_WO[:, 2].max() == pytest.approx(1.0, abs=0.005)
    assert seen.table.offset == pytest.approx(0.9, abs=0.001)


@pytest.mark.parametrize("caching", [True, False])
def test_the_rendered_camera_goes_with_its_frame_and_sees_what_moved(caching):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    carrier, ball = (plant.AddRigidBody(name, inertia) for name in ("carrier", "ball"))
    plant.RegisterVisualGeometry(ball, RigidTransform(), Sphere(0.05), "ball", [1, 1, 1, 1])
    plant.Finalize()
    settings = CameraSettings(width=64, height=48, noise=SILENT)
    frame = plant.GetBodyFrameIdOrThrow(carrier.index())
    camera = make_depth_camera(builder, scene_graph, frame, RigidTransform(), settings, render=True)
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    if not caching:
        root.DisableCaching()
    own = plant.GetMyMutableContextFromRoot(root)
    for X_WP, distance in ((RigidTransform(), 0.8), (RigidTransform([0.3, -2.0, 1.0]), 1.5)):
        plant.SetFreeBodyPose(own, carrier, X_WP)
        plant.SetFreeBodyPose(own, ball, X_WP @ RigidTransform([0.0, 0.0, distance + 0.05]))
        image = camera.GetOutputPort("depth_image").Eval(camera.GetMyContextFromRoot(root))
        assert image.data[24, 32, 0] == pytest.approx(distance, abs=5e-3)


def test_no_renderer_burdens_the_plant_s_scene_graph():
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    scene_graph.RegisterSource("test")
    world = scene_graph.world_frame_id()
    make_depth_camera(builder, scene_graph, world, RigidTransform(), render=True)
    assert scene_graph.RendererCount() == 0
    builder.Build()


def test_a_camera_that_sees_nothing_is_refused():
    with pytest.raises(BadInput, match="sees nothing"):
        scene(CameraSettings(width=0), render=False)


def test_a_machine_whose_renderer_fails_or_hangs_has_no_egl(monkeypatch):
    def fails(*args, **kwargs):
        return subprocess.CompletedProcess(args, 134)

    def hangs(*args, **kwargs):
        raise subprocess.TimeoutExpired("python", 60.0)

    for broken in (fails, hangs):
        monkeypatch.setattr(subprocess, "run", broken)
        assert egl.egl_available.__wrapped__() is False
