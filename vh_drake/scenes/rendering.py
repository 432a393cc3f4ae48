"""A scene graph of its own for a renderer."""

from collections.abc import Mapping

from pydrake.geometry import (
    FrameId,
    GeometryFrame,
    GeometryInstance,
    MakeRenderEngineVtk,
    RenderEngineVtkParams,
    Role,
    SceneGraph,
    SourceId,
)
from pydrake.systems.framework import DiagramBuilder

from vh_drake.systems.frame_poses import FramePoses


def add_rendered_copy(
    builder: DiagramBuilder, scene_graph: SceneGraph, name: str
) -> tuple[SceneGraph, Mapping[FrameId, FrameId]]:
    """Copy what cameras see into a scene graph with a renderer, and let it move alike.

    A renderer takes over all poses whenever one changes. In the plant's own scene graph that
    would be in every step of the simulation; a copy follows only when an image is asked for.

    Args:
        builder: takes the copy.
        scene_graph: in the builder, with all geometry that shall be seen.
        name: of the renderer, and the beginning of the new systems' names.

    Returns:
        The copy, and the copied frame of each original one.
    """
    inspector = scene_graph.model_inspector()
    copy = builder.AddNamedSystem(f"{name}_scene", SceneGraph())
    copy.AddRenderer(name, MakeRenderEngineVtk(RenderEngineVtkParams(backend="EGL")))
    source = copy.RegisterSource(name)
    world = inspector.world_frame_id()
    moving = {
        frame: copy.RegisterFrame(source, GeometryFrame(f"frame_{frame.get_value()}"))
        for frame in inspector.GetAllFrameIds()
        if frame != world
    }
    frames = {world: copy.world_frame_id(), **moving}
    _copy_geometry(scene_graph, copy, source, frames)
    poses = builder.AddNamedSystem(f"{name}_poses", FramePoses(moving))
    builder.Connect(scene_graph.get_query_output_port(), poses.GetInputPort("geometry_query"))
    builder.Connect(poses.GetOutputPort("poses"), copy.get_source_pose_port(source))
    return copy, frames


def _copy_geometry(
    scene_graph: SceneGraph, copy: SceneGraph, source: SourceId, frames: Mapping[FrameId, FrameId]
) -> None:
    """All that has the perception role, in this role alone."""
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kPerception):
        pose, shape = inspector.GetPoseInFrame(geometry), inspector.GetShape(geometry)
        instance = GeometryInstance(pose, shape, inspector.GetName(geometry))
        instance.set_perception_properties(inspector.GetPerceptionProperties(geometry))
        copy.RegisterGeometry(source, frames[inspector.GetFrameId(geometry)], instance)
