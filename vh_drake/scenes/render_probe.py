"""Renders one small depth image through EGL and prints the depth in its middle [m].

Run as a process of its own (`python -m vh_drake.scenes.render_probe`), because a missing
or broken graphics driver may end the process instead of raising.
"""

from pydrake.geometry import (
    Box,
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    GeometryInstance,
    MakeRenderEngineVtk,
    PerceptionProperties,
    RenderCameraCore,
    RenderEngineVtkParams,
    RenderLabel,
    Rgba,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo, RgbdSensor

BOX_DEPTH_M = 0.95  # From the camera at the origin to the near face of the box.


def rendered_depth() -> float:
    """Depth in the middle of an image of a box whose near face is `BOX_DEPTH_M` away [m]."""
    builder = DiagramBuilder()
    scene_graph = SceneGraph()
    builder.AddSystem(scene_graph)
    scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(RenderEngineVtkParams(backend="EGL")))
    _add_box(scene_graph)
    color, depth = _cameras()
    sensor = RgbdSensor(SceneGraph.world_frame_id(), RigidTransform(), color, depth)
    builder.AddSystem(sensor)
    builder.Connect(scene_graph.get_query_output_port(), sensor.query_object_input_port())
    diagram = builder.Build()
    context = sensor.GetMyContextFromRoot(diagram.CreateDefaultContext())
    image = sensor.depth_image_32F_output_port().Eval(context)
    return float(image.at(image.width() // 2, image.height() // 2)[0])


def _add_box(scene_graph: SceneGraph) -> None:
    source = scene_graph.RegisterSource("probe")
    box = GeometryInstance(RigidTransform([0.0, 0.0, 1.0]), Box(1.0, 1.0, 0.1), "box")
    properties = PerceptionProperties()
    properties.AddProperty("phong", "diffuse", Rgba(0.5, 0.5, 0.5, 1.0))
    properties.AddProperty("label", "id", RenderLabel.kDontCare)
    box.set_perception_properties(properties)
    scene_graph.RegisterAnchoredGeometry(source, box)


def _cameras() -> tuple[ColorRenderCamera, DepthRenderCamera]:
    core = RenderCameraCore(
        "vtk", CameraInfo(32, 24, 0.8), ClippingRange(0.01, 10.0), RigidTransform()
    )
    return ColorRenderCamera(core), DepthRenderCamera(core, DepthRange(0.1, 5.0))


if __name__ == "__main__":
    print(rendered_depth())
