import numpy as np
import pytest
from leaf import Leaf
from pydrake.geometry import FramePoseVector, GeometryFrame, SceneGraph
from pydrake.math import RigidTransform, RotationMatrix

from vh_drake.systems.frame_poses import FramePoses

X_WF = RigidTransform(RotationMatrix.MakeXRotation(0.3), [0.1, 0.2, 0.3])
X_WG = RigidTransform(RotationMatrix.MakeZRotation(-0.8), [-1.0, 0.5, 0.0])


class Scene:
    """Two frames, and copies of them in another scene graph."""

    def __init__(self):
        self.graph, self.copy = SceneGraph(), SceneGraph()
        self.source = self.graph.RegisterSource("original")
        other = self.copy.RegisterSource("copy")
        self.frames = [
            self.graph.RegisterFrame(self.source, GeometryFrame(name)) for name in ("f", "g")
        ]
        self.copies = [self.copy.RegisterFrame(other, GeometryFrame(name)) for name in ("f", "g")]
        self.system = FramePoses(dict(zip(self.frames, self.copies, strict=True)))

    def leaf(self, X_WF, X_WG, caching=True):
        self.context = self.graph.CreateDefaultContext()
        poses = FramePoseVector()
        for frame, X in zip(self.frames, (X_WF, X_WG), strict=True):
            poses.set_value(frame, X)
        self.graph.get_source_pose_port(self.source).FixValue(self.context, poses)
        query = self.graph.get_query_output_port().Eval(self.context)
        return Leaf(self.system, caching=caching, geometry_query=query)


@pytest.mark.parametrize("caching", [True, False])
def test_copies_are_where_their_originals_are(caching):
    scene = Scene()
    poses = scene.leaf(X_WF, X_WG, caching).get("poses")
    assert poses.size() == 2
    for copy, X in zip(scene.copies, (X_WF, X_WG), strict=True):
        np.testing.assert_allclose(poses.value(copy).GetAsMatrix4(), X.GetAsMatrix4(), atol=1e-14)


def test_two_contexts_follow_their_own_scenes():
    one, two = Scene(), Scene()
    first, second = one.leaf(X_WF, X_WG), two.leaf(X_WG, X_WF)
    for leaf, scene, X in ((first, one, X_WF), (second, two, X_WG)):
        pose = leaf.get("poses").value(scene.copies[0])
        np.testing.assert_allclose(pose.GetAsMatrix4(), X.GetAsMatrix4(), atol=1e-14)
