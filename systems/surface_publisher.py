"""The estimated surface in Meshcat."""

from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from vh_drake.geometry.colors import TOP_STD_M, variance_colors
from vh_drake.geometry.glyphs import ColorMesh
from vh_drake.grasping.phases import hand_is_open
from vh_drake.systems.meshcat_publisher import PERIOD_S, MeshcatPublisher, Picture
from vh_drake.types import Surface


class SurfacePublisher(MeshcatPublisher):
    """Shows the estimate, coloured by its standard deviation, until the hand closes.

    .. pydrake_system::

        name: SurfacePublisher
        input_ports:
        - surface
        - phase

    | port    | direction | type    | unit | meaning              |
    |---------|-----------|---------|------|----------------------|
    | surface | in        | Surface | m    | estimate             |
    | phase   | in        | str     | -    | of the behaviour     |

    Each estimate has a path of its own, `/estimate/0`, `/estimate/1`, ...

    Args:
        meshcat: where it draws.
        path: under which it draws.
        top_std: standard deviation of the potential at the end of the colour scale.
        period_s: between two looks.
    """

    def __init__(
        self,
        meshcat: Meshcat,
        path: str = "/estimate",
        *,
        top_std: float = TOP_STD_M,
        period_s: float = PERIOD_S,
    ) -> None:
        super().__init__(meshcat, path, period_s)
        self._top_std = top_std
        self._surface = self.DeclareAbstractInputPort("surface", Value[object](Surface()))
        self._phase = self.DeclareAbstractInputPort("phase", Value[str](""))

    def picture(self, context: Context) -> Picture:
        """The estimate, if there is one."""
        surface: Surface = self._surface.Eval(context)
        shown = len(surface.faces) and hand_is_open(self._phase.Eval(context))
        return (surface,) if shown else ()

    def draw(self, path: str, *picture: object) -> None:
        """Puts a surface under a path."""
        (surface,) = picture
        assert isinstance(surface, Surface)
        colors = variance_colors(surface.variance, top_std=self._top_std)
        self.draw_mesh(path, ColorMesh(surface.vertices, surface.faces, colors))
