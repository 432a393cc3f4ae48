"""Tries one LeafSystem without a diagram: its inputs fixed, its outputs read.

Drake's handles must not outlive what they point to. pybind11 knows an object by its address:
where a handle of a freed context still lives, a new context at the same address is taken for
the old one, and the process crashes. So a `Leaf` keeps system, context and simulator together,
and gives away copies of vectors.
"""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem, PortDataType


class Leaf:
    """A system with a context of its own; two of one system are two contexts."""

    def __init__(
        self, system: LeafSystem, *, time_s: float = 0.0, caching: bool = True, **inputs: object
    ) -> None:
        self.system = system
        self.context = system.CreateDefaultContext()
        self.context.SetTime(time_s)
        if not caching:
            self.context.DisableCaching()
        self._simulator: Simulator | None = None
        self.fix(**inputs)

    def fix(self, **inputs: object) -> "Leaf":
        """Fix input ports by their names."""
        for name, value in inputs.items():
            port = self.system.GetInputPort(name)
            if port.get_data_type() == PortDataType.kVectorValued:
                port.FixValue(self.context, np.atleast_1d(np.asarray(value, float)))
            else:
                port.FixValue(self.context, _like(port.Allocate(), value))
        return self

    def get(self, name: str) -> object:
        """What an output port says now."""
        port = self.system.GetOutputPort(name)
        value = port.Eval(self.context)
        return np.array(value) if port.get_data_type() == PortDataType.kVectorValued else value

    def advance(self, duration_s: float) -> "Leaf":
        """Let time pass, up to and with the events at its end."""
        if self._simulator is None:
            self._simulator = Simulator(self.system, self.context)
            self._simulator.Initialize()
        self._simulator.AdvanceTo(self.context.get_time() + duration_s)
        self._simulator.AdvancePendingEvents()
        return self


def _like(model: AbstractValue, value: object) -> AbstractValue:
    """The value in the type of value that a port takes."""
    kind = type(model)
    return kind(value) if kind is not Value[object] else Value[object](value)


def port_names(system: LeafSystem) -> tuple[list[str], list[str]]:
    """Names of inputs and of outputs."""
    inputs = [system.get_input_port(i).get_name() for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i).get_name() for i in range(system.num_output_ports())]
    return inputs, outputs
