"""Numba has no types of its own; with these, a compiled function keeps its signature."""

from collections.abc import Callable
from typing import TypeVar, overload

F = TypeVar("F", bound=Callable[..., object])

prange = range

@overload
def njit(function: F, /) -> F: ...
@overload
def njit(
    *,
    cache: bool = ...,
    error_model: str = ...,
    fastmath: bool | set[str] = ...,
    inline: str = ...,
    nogil: bool = ...,
    parallel: bool = ...,
    _nrt: bool = ...,
) -> Callable[[F], F]: ...
def get_num_threads() -> int: ...
def set_num_threads(n: int) -> None: ...
