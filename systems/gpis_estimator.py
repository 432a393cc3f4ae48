"""Surface estimation as a LeafSystem."""

from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, EventStatus, LeafSystem, State

from vh_drake.gpis.surface import SurfaceSettings, estimate_surface
from vh_drake.types import ContactSet, ObjectView, Surface


class GpisEstimator(LeafSystem):
    """Estimates the closed surface of an object from a view and touches, when asked.

    .. pydrake_system::

        name: GpisEstimator
        input_ports:
        - object_view
        - contacts
        - request
        output_ports:
        - surface
        - served

    | port        | direction | type       | unit | meaning                                      |
    |-------------|-----------|------------|------|----------------------------------------------|
    | object_view | in        | ObjectView | m    | segmented object, table, camera              |
    | contacts    | in        | ContactSet | m    | touches so far                               |
    | request     | in        | vector (1) |      | an id; a new one asks for an estimate, 0: no |
    | surface     | out       | Surface    | m    | the last estimate                            |
    | served      | out       | vector (1) |      | id of the request that it answers            |

    A request is answered at the next of the periodic looks (an event), which takes the inputs of
    that instant; the outputs only copy the state.

    Args:
        settings: of the estimate.
        period_s: between looks at the request.
    """

    def __init__(self, settings: SurfaceSettings | None = None, period_s: float = 0.02) -> None:
        super().__init__()
        self._settings = settings or SurfaceSettings()
        self._view = self.DeclareAbstractInputPort("object_view", Value[object](ObjectView()))
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object](ContactSet()))
        self._request = self.DeclareVectorInputPort("request", 1)
        self._surface = self.DeclareAbstractState(Value[object](Surface()))
        self._served = self.DeclareDiscreteState(1)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period_s, 0.0, self._serve)
        self.DeclareStateOutputPort("surface", self._surface)
        self.DeclareVectorOutputPort(
            "served", 1, self._calc_served, prerequisites_of_calc={self.xd_ticket()}
        )

    def _serve(self, context: Context, state: State) -> EventStatus:
        request = self._request.Eval(context)[0]
        if request in (0.0, context.get_discrete_state(self._served)[0]):
            return EventStatus.DidNothing()
        surface = estimate_surface(
            self._view.Eval(context), self._contacts.Eval(context), self._settings
        )
        state.get_mutable_abstract_state(self._surface).set_value(surface)
        state.get_mutable_discrete_state(self._served).set_value([request])
        return EventStatus.Succeeded()

    def _calc_served(self, context: Context, output: BasicVector) -> None:
        output[0] = context.get_discrete_state(self._served)[0]
