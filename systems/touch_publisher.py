"""The planned touch in Meshcat."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from vh_drake.exploration.trajectory import position
from vh_drake.geometry.glyphs import arrows, balls, joined, tube
from vh_drake.systems.meshcat_publisher import PERIOD_S, MeshcatPublisher, Picture
from vh_drake.types import TouchPlan

COLOR = (1.0, 0.45, 0.0)
BALL_M, ARROW_M, TUBE_M = 0.005, 0.035, 0.002
TOUCHING = ("plan a touch", "touch")  # phases, without the running motion


class TouchPublisher(MeshcatPublisher):
    """Shows the curve of the fingertip, its target and the normal there, while it touches.

    .. pydrake_system::

        name: TouchPublisher
        input_ports:
        - touch_plan
        - phase

    | port       | direction | type      | unit | meaning             |
    |------------|-----------|-----------|------|---------------------|
    | touch_plan | in        | TouchPlan | m    | the touch under way |
    | phase      | in        | str       | -    | of the behaviour    |

    Args:
        meshcat: where it draws.
        path: under which it draws.
        period_s: between two looks.
    """

    def __init__(
        self, meshcat: Meshcat, path: str = "/touch", *, period_s: float = PERIOD_S
    ) -> None:
        super().__init__(meshcat, path, period_s)
        self._plan = self.DeclareAbstractInputPort("touch_plan", Value[object](TouchPlan()))
        self._phase = self.DeclareAbstractInputPort("phase", Value[str](""))

    def picture(self, context: Context) -> Picture:
        """The plan, while it counts."""
        plan: TouchPlan = self._plan.Eval(context)
        phase: str = self._phase.Eval(context)
        shown = phase.partition(":")[0] in TOUCHING and np.ptp(plan.control_points) > 0
        return (plan,) if shown else ()

    def draw(self, path: str, *picture: object) -> None:
        """Puts curve, target and normal under a path."""
        (plan,) = picture
        assert isinstance(plan, TouchPlan)
        curve = np.array([position(plan.control_points, tau) for tau in np.linspace(0, 1, 25)])
        color, p = np.array(COLOR), plan.p_WT[None]
        target = balls(p, color[None], radius=BALL_M)
        normal = arrows(p, plan.n_WT[None], color[None], length=ARROW_M, radius=TUBE_M)
        self.draw_mesh(path, joined([tube(curve, color, radius=TUBE_M), target, normal]))
