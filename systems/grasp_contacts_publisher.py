"""Where the chosen grasp is thought to touch, with its friction cones, in Meshcat."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from vh_drake.geometry.glyphs import balls, cones, joined
from vh_drake.grasping.field import object_field
from vh_drake.grasping.phases import hand_is_open
from vh_drake.grasping.story import GraspRecord, Story
from vh_drake.hand.model import HandModel
from vh_drake.learning.labels import LabelSettings, nominal_closures
from vh_drake.systems.meshcat_publisher import PERIOD_S, MeshcatPublisher, Picture
from vh_drake.types import Candidates, ObjectView, Surface

COLOR = (0.1, 0.3, 1.0)
BALL_M, CONE_M = 0.003, 0.015


class GraspContactsPublisher(MeshcatPublisher):
    """Shows the contacts of the chosen grasp on the estimate, each with its friction cone.

    .. pydrake_system::

        name: GraspContactsPublisher
        input_ports:
        - surface
        - view
        - story
        - phase

    | port    | direction | type       | unit | meaning                       |
    |---------|-----------|------------|------|-------------------------------|
    | surface | in        | Surface    | m    | estimate                      |
    | view    | in        | ObjectView | m    | the look, for its table       |
    | story   | in        | Story      | -    | whose last grasp is the chosen |
    | phase   | in        | str        | -    | of the behaviour              |

    Contacts are where the hand touches the estimate when it comes on and closes without
    dynamics, as the planners' rating has it. A cone stands on its contact and opens along the
    outward normal, with the coefficient of friction as its slope; forces within its mirror image
    do not slip. All disappear when the hand closes.

    Args:
        hand: that grasps.
        meshcat: where it draws.
        path: under which it draws.
        settings: friction, and how the hand comes on.
        period_s: between two looks.
    """

    def __init__(
        self,
        hand: HandModel,
        meshcat: Meshcat,
        path: str = "/grasp_contacts",
        *,
        settings: LabelSettings | None = None,
        period_s: float = PERIOD_S,
    ) -> None:
        super().__init__(meshcat, path, period_s)
        self._hand, self._settings = hand, settings or LabelSettings()
        self._inputs = {
            name: self.DeclareAbstractInputPort(name, AbstractValue.Make(value))
            for name, value in (
                ("surface", Surface()),
                ("view", ObjectView()),
                ("story", Story()),
                ("phase", ""),
            )
        }

    def picture(self, context: Context) -> Picture:
        """The chosen grasp and what it shall take hold of."""
        surface, view, story, phase = (port.Eval(context) for port in self._inputs.values())
        chosen = phase.startswith("grasp") and hand_is_open(phase) and story.grasps
        return (surface, view, story.grasps[-1]) if chosen and len(surface.faces) else ()

    def draw(self, path: str, *picture: object) -> None:
        """Puts contacts and cones under a path."""
        surface, view, grasp = picture
        assert isinstance(surface, Surface)
        assert isinstance(view, ObjectView)
        assert isinstance(grasp, GraspRecord)
        one = Candidates(grasp.X_WH[None], (grasp.motion,), (grasp.planner,))
        field = object_field(surface, view.table)
        (closure,) = nominal_closures(one, field, self._hand, self._settings)
        p, n = closure.p_WC, closure.n_WC
        colors = np.tile(COLOR, (len(p), 1))
        slope = self._settings.friction
        friction_cones = cones(p, n, colors, length=CONE_M, slope=slope)
        self.draw_mesh(path, joined([balls(p, colors, radius=BALL_M), friction_cones]))
