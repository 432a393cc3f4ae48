"""Depth images by ray casting on the CPU, for machines without EGL."""

from pydrake.common.value import Value
from pydrake.geometry import FrameId, QueryObject
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context
from pydrake.systems.sensors import ImageDepth32F

from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.ray_caster import cast_depth
from vh_drake.sensing.scene_triangles import perceived_triangles
from vh_drake.systems.collectable import CollectableSystem


class RaycastDepth(CollectableSystem):
    """Does what Drake's RgbdSensor does for depth, without a renderer.

    .. pydrake_system::

        name: RaycastDepth
        input_ports:
        - geometry_query
        output_ports:
        - depth_image_32f
        - body_pose_in_world

    | port               | direction | type           | unit | meaning                           |
    |--------------------|-----------|----------------|------|-----------------------------------|
    | geometry_query     | in        | QueryObject    | m    | of the scene graph                |
    | depth_image_32f    | out       | ImageDepth32F  | m    | along +z; 0 too near, inf nothing |
    | body_pose_in_world | out       | RigidTransform | m    | optical frame: +z ahead, +y down  |

    The port names are those of RgbdSensor. Geometry with the perception role is seen.

    Args:
        parent_id: frame that carries the camera.
        X_PC: optical frame in it.
        intrinsics: the camera.
        min_depth_m: nearer hits give 0.
        max_depth_m: farther hits give infinity.
    """

    def __init__(
        self,
        parent_id: FrameId,
        X_PC: RigidTransform,
        intrinsics: Intrinsics,
        *,
        min_depth_m: float = 0.3,
        max_depth_m: float = 3.0,
    ) -> None:
        super().__init__()
        self._parent_id = parent_id
        self._X_PC = X_PC
        self._intrinsics = intrinsics
        self._range = min_depth_m, max_depth_m
        self._query = self.DeclareAbstractInputPort("geometry_query", Value(QueryObject()))
        after = {self._query.ticket()}
        self._pose = self.DeclareAbstractOutputPort(
            "body_pose_in_world",
            lambda: Value(RigidTransform()),
            self._calc_pose,
            prerequisites_of_calc=after,
        )
        self.DeclareAbstractOutputPort(
            "depth_image_32f",
            lambda: Value(ImageDepth32F(intrinsics.width, intrinsics.height)),
            self._calc_depth,
            prerequisites_of_calc=after,
        )

    def _calc_pose(self, context: Context, output: Value) -> None:
        X_WP = self._query.Eval(context).GetPoseInWorld(self._parent_id)
        output.set_value(X_WP @ self._X_PC)

    def _calc_depth(self, context: Context, output: Value) -> None:
        X_CW = self._pose.Eval(context).inverse()
        triangles_W = perceived_triangles(self._query.Eval(context))
        flat = X_CW.multiply(triangles_W.reshape(-1, 3).T).T
        depth = cast_depth(
            flat.reshape(-1, 3, 3),
            self._intrinsics,
            min_depth_m=self._range[0],
            max_depth_m=self._range[1],
        )
        output.get_mutable_value().mutable_data[:, :, 0] = depth
