"""LeafSystems of Python that are freed together with their diagram."""

import weakref
from collections.abc import Callable
from typing import Any

from pydrake.systems.framework import LeafSystem, OutputPort

_DrakeType: Any = type(LeafSystem)


class Collectable(_DrakeType):
    """Makes classes that keep their attributes where Drake's class keeps them.

    Under Python 3.11 any other subclass refers to the dictionary of its attributes twice. The
    garbage collector then takes what the dictionary holds for used from elsewhere.
    """

    def __new__(cls, name: str, bases: tuple[type, ...], members: dict[str, Any]) -> Any:
        """The class."""
        return super().__new__(cls, name, bases, {"__slots__": (), **members})


class CollectableSystem(LeafSystem, metaclass=Collectable):
    """A LeafSystem that the garbage collector can free.

    Diagram, builder and systems refer to each other in rings, which Python's garbage collector
    has to find and to break. A single system that it can't see through keeps the whole diagram
    for ever. So Drake's C++, into which the collector can't look, is not given the functions that
    compute outputs and cache entries, with all that they refer to: it gets functions that know
    the system weakly.

    As with any other system of Python, a diagram or a variable must keep it while it is used.
    `gc.collect()` frees a diagram that nobody uses any more.
    """

    def __init__(self) -> None:
        super().__init__()
        self._functions: list[Callable[..., Any]] = []

    def weakly(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function in a form that Drake may keep; it lives as long as this system."""
        place, me = len(self._functions), weakref.ref(self)
        self._functions.append(function)

        def call(*args: Any) -> Any:
            system = me()
            assert system is not None  # Only the system itself calls.
            return system._functions[place](*args)

        return call

    def DeclareVectorOutputPort(self, *args: Any, **options: Any) -> OutputPort:
        """As Drake's."""
        args, options = self._weak(args, options)
        return super().DeclareVectorOutputPort(*args, **options)

    def DeclareAbstractOutputPort(self, *args: Any, **options: Any) -> OutputPort:
        """As Drake's."""
        args, options = self._weak(args, options)
        return super().DeclareAbstractOutputPort(*args, **options)

    def _weak(
        self, args: tuple[Any, ...], options: dict[str, Any]
    ) -> tuple[tuple[Any, ...], dict[str, Any]]:
        def weak(x: Any) -> Any:
            return self.weakly(x) if callable(x) else x

        return tuple(map(weak, args)), {name: weak(x) for name, x in options.items()}
