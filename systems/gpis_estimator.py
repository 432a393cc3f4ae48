"""Surface estimation as a LeafSystem."""

from pydrake.common.value import Value
from pydrake.systems.framework import Context

from vh_drake.gpis.surface import SurfaceSettings, estimate_surface
from vh_drake.systems.on_request import PERIOD_S, OnRequest
from vh_drake.types import ContactSet, ObjectView, Surface


class GpisEstimator(OnRequest):
    """Estimates the closed surface of an object from a view and touches, when asked.

    .. pydrake_system::

        name: GpisEstimator
        input_ports:
        - request
        - object_view
        - contacts
        output_ports:
        - surface
        - served

    | port        | direction | type       | unit | meaning                                      |
    |-------------|-----------|------------|------|----------------------------------------------|
    | request     | in        | vector (1) |      | an id; a new one asks for an estimate, 0: no |
    | object_view | in        | ObjectView | m    | segmented object, table, camera              |
    | contacts    | in        | ContactSet | m    | touches so far                               |
    | surface     | out       | Surface    | m    | the last estimate                            |
    | served      | out       | vector (1) |      | id of the request that it answers            |

    Args:
        settings: of the estimate.
        period_s: between looks at the request.
    """

    def __init__(self, settings: SurfaceSettings | None = None, period_s: float = PERIOD_S) -> None:
        super().__init__({"surface": Surface()}, period_s)
        self._settings = settings or SurfaceSettings()
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object](ContactSet()))

    def answer(self, context: Context) -> tuple[Surface]:
        """The estimate."""
        view, contacts = self._view.Eval(context), self._contacts.Eval(context)
        return (estimate_surface(view, contacts, self._settings),)
