"""What the systems share that work for long, but only when asked."""

import abc
import dataclasses as dc
from collections.abc import Mapping, Sequence

from pydrake.common.value import Value
from pydrake.systems.framework import (
    AbstractStateIndex,
    BasicVector,
    Context,
    EventStatus,
    State,
)

from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Immutable

PERIOD_S = 0.02


@dc.dataclass(frozen=True, eq=False)
class _Kept(Immutable):
    """An answer; a tuple by itself would be copied member by member in every update."""

    value: object


class OnRequest(CollectableSystem):
    """Computes its outputs anew when the number on its port `request` changes.

    .. pydrake_system::

        name: OnRequest
        input_ports:
        - request
        output_ports:
        - (the outputs)
        - served

    | port    | direction | type       | unit | meaning                                    |
    |---------|-----------|------------|------|--------------------------------------------|
    | request | in        | vector (1) |      | an id; a new one asks, 0: no               |
    | served  | out       | vector (1) |      | id of the request that the outputs answer  |

    A request is answered at the next of the periodic looks (an event), which takes the inputs of
    that instant; the outputs only copy the state. Connect `request` to the `served` of another
    such system to work on its answer.

    Args:
        outputs: values before the first request, by the port's name.
        period_s: between looks at the request.
    """

    def __init__(self, outputs: Mapping[str, object], period_s: float = PERIOD_S) -> None:
        super().__init__()
        self._request = self.DeclareVectorInputPort("request", 1)
        self._answers = [
            self.DeclareAbstractState(Value[object](_Kept(x))) for x in outputs.values()
        ]
        self._served = self.DeclareDiscreteState(1)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period_s, 0.0, self._serve)
        for (name, first), index in zip(outputs.items(), self._answers, strict=True):
            self.DeclareAbstractOutputPort(
                name,
                lambda first=first: Value[object](first),
                lambda context, output, index=index: self._calc_answer(context, output, index),
                prerequisites_of_calc={self.abstract_state_ticket(index)},
            )
        self.DeclareVectorOutputPort(
            "served", 1, self._calc_served, prerequisites_of_calc={self.xd_ticket()}
        )

    @abc.abstractmethod
    def answer(self, context: Context) -> Sequence[object]:
        """The outputs, in their order, for the inputs of a context."""

    def _serve(self, context: Context, state: State) -> EventStatus:
        request = self._request.Eval(context)[0]
        if request in (0.0, context.get_discrete_state(self._served)[0]):
            return EventStatus.DidNothing()
        for index, answer in zip(self._answers, self.answer(context), strict=True):
            state.get_mutable_abstract_state(index).set_value(_Kept(answer))
        state.get_mutable_discrete_state(self._served).set_value([request])
        return EventStatus.Succeeded()

    def _calc_answer(self, context: Context, output: Value, index: AbstractStateIndex) -> None:
        kept: _Kept = context.get_abstract_state(index).get_value()
        output.set_value(kept.value)

    def _calc_served(self, context: Context, output: BasicVector) -> None:
        output[0] = context.get_discrete_state(self._served)[0]
