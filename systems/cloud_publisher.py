"""The seen points of the object in Meshcat."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat, Rgba
from pydrake.perception import PointCloud
from pydrake.systems.framework import Context

from vh_drake.grasping.phases import hand_is_open
from vh_drake.systems.meshcat_publisher import PERIOD_S, MeshcatPublisher, Picture
from vh_drake.types import ObjectView

COLOR = Rgba(0.05, 0.35, 0.85, 1.0)
POINT_M = 0.003


class CloudPublisher(MeshcatPublisher):
    """Shows the object's points that the camera saw, until the hand closes.

    .. pydrake_system::

        name: CloudPublisher
        input_ports:
        - view
        - phase

    | port  | direction | type       | unit | meaning          |
    |-------|-----------|------------|------|------------------|
    | view  | in        | ObjectView | m    | segmented object |
    | phase | in        | str        | -    | of the behaviour |

    Args:
        meshcat: where it draws.
        path: under which it draws.
        period_s: between two looks.
    """

    def __init__(
        self, meshcat: Meshcat, path: str = "/cloud", *, period_s: float = PERIOD_S
    ) -> None:
        super().__init__(meshcat, path, period_s)
        self._view = self.DeclareAbstractInputPort("view", Value[object](ObjectView()))
        self._phase = self.DeclareAbstractInputPort("phase", Value[str](""))

    def picture(self, context: Context) -> Picture:
        """The view, if anything was seen."""
        view: ObjectView = self._view.Eval(context)
        shown = len(view.p_WO) and hand_is_open(self._phase.Eval(context))
        return (view,) if shown else ()

    def draw(self, path: str, *picture: object) -> None:
        """Puts points under a path."""
        (view,) = picture
        assert isinstance(view, ObjectView)
        cloud = PointCloud(len(view.p_WO))
        cloud.mutable_xyzs()[:] = view.p_WO.T.astype(np.float32)
        self._meshcat.SetObject(path, cloud, POINT_M, COLOR)
