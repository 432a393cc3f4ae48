"""The felt contacts in Meshcat."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from vh_drake.geometry.glyphs import arrows, balls, joined
from vh_drake.grasping.phases import hand_is_open
from vh_drake.systems.meshcat_publisher import PERIOD_S, MeshcatPublisher, Picture
from vh_drake.types import ContactSet

COLOR = (0.9, 0.05, 0.1)
BALL_M, ARROW_M, SHAFT_M = 0.006, 0.05, 0.0022


class ContactsPublisher(MeshcatPublisher):
    """Shows contacts as red balls and their outward normals as arrows, until the hand closes.

    .. pydrake_system::

        name: ContactsPublisher
        input_ports:
        - contacts
        - phase

    | port     | direction | type       | unit | meaning          |
    |----------|-----------|------------|------|------------------|
    | contacts | in        | ContactSet | m    | felt so far      |
    | phase    | in        | str        | -    | of the behaviour |

    Args:
        meshcat: where it draws.
        path: under which it draws.
        period_s: between two looks.
    """

    def __init__(
        self, meshcat: Meshcat, path: str = "/contacts", *, period_s: float = PERIOD_S
    ) -> None:
        super().__init__(meshcat, path, period_s)
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object](ContactSet()))
        self._phase = self.DeclareAbstractInputPort("phase", Value[str](""))

    def picture(self, context: Context) -> Picture:
        """The contacts, if anything was felt."""
        contacts: ContactSet = self._contacts.Eval(context)
        shown = len(contacts) and hand_is_open(self._phase.Eval(context))
        return (contacts,) if shown else ()

    def draw(self, path: str, *picture: object) -> None:
        """Puts contacts under a path."""
        (contacts,) = picture
        assert isinstance(contacts, ContactSet)
        p, n = contacts.p_WC, contacts.n_WC
        colors = np.tile(COLOR, (len(p), 1))
        normals = arrows(p, n, colors, length=ARROW_M, radius=SHAFT_M)
        self.draw_mesh(path, joined([balls(p, colors, radius=BALL_M), normals]))
