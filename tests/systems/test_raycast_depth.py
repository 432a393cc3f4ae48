import gc
import weakref

import numpy as np
import pytest
import trimesh
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    FrameId,
    GeometryInstance,
    HalfSpace,
    Mesh,
    MeshcatCone,
    PerceptionProperties,
    SceneGraph,
    Sphere,
)  # fmt: skip
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from vh_drake.errors import BadInput
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.scene_triangles import shape_triangles
from vh_drake.systems.raycast_depth import RaycastDepth

PINHOLE = Intrinsics.from_fov(64, 48, 0.8)
X_WC = RigidTransform(np.diag([1.0, -1.0, -1.0, 1.0]) + np.eye(4)[:, 3:] @ [[0, 0, 0, 0]])


def looking_down(z_m: float) -> RigidTransform:
    X = RigidTransform(X_WC)
    X.set_translation([0.0, 0.0, z_m])
    return X


def diagram_with(shape, X_WG, camera_z=1.5):
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    source = scene_graph.RegisterSource("test")
    instance = GeometryInstance(X_WG, shape, "thing")
    instance.set_perception_properties(PerceptionProperties())
    scene_graph.RegisterAnchoredGeometry(source, instance)
    caster = builder.AddSystem(
        RaycastDepth(scene_graph.world_frame_id(), looking_down(camera_z), PINHOLE)
    )
    builder.Connect(scene_graph.get_query_output_port(), caster.GetInputPort("geometry_query"))
    return builder.Build(), caster


def depth(diagram, caster, *, caching=True):
    context = diagram.CreateDefaultContext()
    if not caching:
        context.DisableCaching()
    mine = caster.GetMyContextFromRoot(context)
    return caster.GetOutputPort("depth_image_32f").Eval(mine).data[:, :, 0].copy()


def test_a_box_is_seen_at_its_height_and_the_rest_is_infinite():
    diagram, caster = diagram_with(Box(0.4, 0.4, 0.2), RigidTransform([0.0, 0.0, 0.5]))
    for caching in (True, False):
        image = depth(diagram, caster, caching=caching)
        assert image[24, 32] == pytest.approx(0.9)
        assert np.isinf(image[0, 0])


def test_the_pose_is_that_of_the_optical_frame():
    diagram, caster = diagram_with(Sphere(0.1), RigidTransform())
    root = diagram.CreateDefaultContext()  # It owns the caster's context.
    context = caster.GetMyContextFromRoot(root)
    pose = caster.GetOutputPort("body_pose_in_world").Eval(context)
    assert pose.IsExactlyEqualTo(looking_down(1.5))


def test_no_handle_of_a_context_outlives_it(monkeypatch):
    """A new context at the old one's address would be taken for it, and Drake would crash."""
    handles = []
    calc = RaycastDepth._calc_depth

    def watched(self, context, output):
        handles.append(weakref.ref(context))
        calc(self, context, output)

    monkeypatch.setattr(RaycastDepth, "_calc_depth", watched)
    diagram, caster = diagram_with(Box(0.4, 0.4, 0.2), RigidTransform([0.0, 0.0, 0.5]))
    gc.disable()  # The garbage of a cycle lives on until its turn comes.
    try:
        depth(diagram, caster)
        assert [handle() for handle in handles] == [None]
    finally:
        gc.enable()


def mesh_file(folder):
    path = folder / "block.obj"
    trimesh.creation.box((0.1, 0.2, 0.3)).export(path)
    return str(path)


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        (Box(0.1, 0.2, 0.3), (0.1, 0.2, 0.3)),
        (Sphere(0.2), (0.4, 0.4, 0.4)),
        (Ellipsoid(0.1, 0.2, 0.3), (0.2, 0.4, 0.6)),
        (Cylinder(0.1, 0.5), (0.2, 0.2, 0.5)),
        (Capsule(0.1, 0.5), (0.2, 0.2, 0.7)),
        (HalfSpace(), (20.0, 20.0, 0.0)),
    ],
)
def test_triangles_have_the_shape_s_extent_about_its_origin(shape, size):
    corners = shape_triangles(shape).reshape(-1, 3)
    np.testing.assert_allclose(corners.max(axis=0), np.array(size) / 2, rtol=0.01, atol=1e-9)
    np.testing.assert_allclose(corners.min(axis=0), -np.array(size) / 2, rtol=0.01, atol=1e-9)


@pytest.mark.parametrize("kind", [Mesh, Convex])
def test_mesh_files_are_read_and_scaled(kind, tmp_path):
    corners = shape_triangles(kind(mesh_file(tmp_path), 2.0)).reshape(-1, 3)
    np.testing.assert_allclose(corners.max(axis=0), [0.1, 0.2, 0.3])


def test_missing_and_damaged_meshes_and_strange_shapes_are_refused(tmp_path):
    with pytest.raises(BadInput, match="no mesh at"):
        shape_triangles(Mesh(str(tmp_path / "missing.obj"), 1.0))
    (tmp_path / "damaged.glb").write_bytes(b"no mesh")
    with pytest.raises(BadInput, match="cannot be read"):
        shape_triangles(Mesh(str(tmp_path / "damaged.glb"), 1.0))
    with pytest.raises(BadInput, match="MeshcatCone"):
        shape_triangles(MeshcatCone(1.0))


def test_an_unknown_parent_frame_is_an_error_of_the_scene_graph():
    diagram, _ = diagram_with(Sphere(0.1), RigidTransform())
    caster = RaycastDepth(FrameId.get_new_id(), RigidTransform(), PINHOLE)
    context = caster.CreateDefaultContext()
    with pytest.raises(RuntimeError):
        caster.GetOutputPort("depth_image_32f").Eval(context)
    assert diagram is not None
