"""What all publishers share: a picture is drawn when it changes, and the one before is hidden."""

import abc
import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context, EventStatus, State

from vh_drake.geometry.glyphs import ColorMesh
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Immutable

PERIOD_S = 0.06

Picture = tuple[object, ...]


@dc.dataclass(frozen=True, eq=False)
class _Shown(Immutable):
    """What was drawn last, and how many pictures were drawn so far."""

    picture: Picture = ()
    count: int = 0


def same(a: object, b: object) -> bool:
    """Whether two values have the same content; a port may compute the same value anew."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return np.array_equal(a, np.asarray(b))
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if dc.is_dataclass(a):
        names = [field.name for field in dc.fields(a)]
        return all(same(getattr(a, name), getattr(b, name)) for name in names)
    return a == b


class MeshcatPublisher(CollectableSystem):
    """Draws what `picture` gives under a path of its own, `<path>/0`, `<path>/1`, ...

    Meshcat can't record a changing mesh, so that each picture stays where it is and is made
    visible for its time only, on the live page and in a recording alike.

    A periodic event looks whether the picture has changed, draws it and remembers it in the
    Context. `ForcedPublish` draws what has changed without remembering.

    Args:
        meshcat: where it draws; its server must belong to the thread that simulates.
        path: under which it draws.
        period_s: between two looks.
    """

    def __init__(self, meshcat: Meshcat, path: str, period_s: float = PERIOD_S) -> None:
        super().__init__()
        self._meshcat, self._path = meshcat, path
        self._shown = self.DeclareAbstractState(Value[object](_Shown()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period_s, 0.0, self._update)
        self.DeclareForcedPublishEvent(self._publish)

    @abc.abstractmethod
    def picture(self, context: Context) -> Picture:
        """The values that are to be drawn now, compared by `same`; () draws nothing."""

    @abc.abstractmethod
    def draw(self, path: str, *picture: object) -> None:
        """Puts a picture under a path."""

    def draw_mesh(self, path: str, mesh: ColorMesh) -> None:
        """Puts coloured triangles under a path."""
        self._meshcat.SetTriangleColorMesh(
            path,
            np.asfortranarray(mesh.vertices.T),
            np.asfortranarray(mesh.faces.T.astype(np.int32)),
            np.asfortranarray(mesh.colors.T),
        )

    def _update(self, context: Context, state: State) -> EventStatus:
        shown = self._redraw(context)
        if shown is None:
            return EventStatus.DidNothing()
        state.get_mutable_abstract_state(self._shown).set_value(shown)
        return EventStatus.Succeeded()

    def _publish(self, context: Context) -> EventStatus:
        return (
            EventStatus.DidNothing() if self._redraw(context) is None else EventStatus.Succeeded()
        )

    def _redraw(self, context: Context) -> _Shown | None:
        """Draws; gives what is shown then, or None where nothing changed."""
        shown: _Shown = context.get_abstract_state(self._shown).get_value()
        picture = self.picture(context)
        if same(picture, shown.picture):
            return None
        time = context.get_time()
        if shown.picture:
            self._show(shown.count - 1, False, time)
        if not picture:
            return _Shown((), shown.count)
        self.draw(f"{self._path}/{shown.count}", *picture)
        self._show(shown.count, False, 0.0)
        self._show(shown.count, True, time)
        return _Shown(picture, shown.count + 1)

    def _show(self, number: int, visible: bool, time: float) -> None:
        path = f"{self._path}/{number}"
        self._meshcat.SetProperty(path, "visible", visible, time_in_recording=time)
