"""Poses of one scene graph's frames for another scene graph."""

from collections.abc import Mapping

from pydrake.common.value import Value
from pydrake.geometry import FrameId, FramePoseVector, QueryObject
from pydrake.systems.framework import Context

from vh_drake.systems.collectable import CollectableSystem


class FramePoses(CollectableSystem):
    """Lets the frames of a copied scene go with those that they were copied from.

    .. pydrake_system::

        name: FramePoses
        input_ports:
        - geometry_query
        output_ports:
        - poses

    | port           | direction | type            | unit | meaning                             |
    |----------------|-----------|-----------------|------|-------------------------------------|
    | geometry_query | in        | QueryObject     | m    | of the originals' scene graph       |
    | poses          | out       | FramePoseVector | m    | X_WF of the copies                  |

    Args:
        copies: the copy's frame of each original frame.
    """

    def __init__(self, copies: Mapping[FrameId, FrameId]) -> None:
        super().__init__()
        self._copies = dict(copies)
        self._query = self.DeclareAbstractInputPort("geometry_query", Value(QueryObject()))
        self.DeclareAbstractOutputPort(
            "poses",
            lambda: Value(FramePoseVector()),
            self._calc_poses,
            prerequisites_of_calc={self._query.ticket()},
        )

    def _calc_poses(self, context: Context, output: Value) -> None:
        query: QueryObject = self._query.Eval(context)
        poses = FramePoseVector()
        for original, copy in self._copies.items():
            poses.set_value(copy, query.GetPoseInWorld(original))
        output.set_value(poses)
