"""Compiler options of kernels, so that each compiles once and in little time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NoReturn, ParamSpec, TypedDict, TypeVar, cast

from numba import njit

P = ParamSpec("P")
R = TypeVar("R")


class KernelOptions(TypedDict, total=False):
    """The options that numba's type hints know; two of those below are not among them."""

    cache: bool
    error_model: Literal["numpy"]
    forceinline: bool


_CACHED = {"cache": True, "no_cfunc_wrapper": True}
CACHED = cast("KernelOptions", _CACHED)
"""For ``numba.njit``: kept on disk, and without the entry for pointers to functions, which nothing
uses and which took a ninth of the time of compiling."""

_OPTIONS = {**_CACHED, "error_model": "numpy", "_nrt": False}
KERNEL = cast("KernelOptions", _OPTIONS)
"""For functions that only fill arrays which they are given.

Such a function owns no array, so it need not count references, which took more than half of the
time of a search: all tables of a scene are counted at every call. It must not create arrays, nor
assign one array to another."""
INNER = cast("KernelOptions", {**_OPTIONS, "forceinline": True})
"""For functions inside a rollout: a call would copy all tables of the scene."""


def callee(options: KernelOptions = CACHED) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return the decorator of a function that only kernels call.

    It gets no entry point for Python, which would unpack every array of every table: a ninth of all
    compiling. Calls from Python raise TypeError.

    Args:
        options: one of the options above.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        dispatcher: Any = njit(**options, **_NO_ENTRY)(function)

        def refuse(*_args: Any, **_kwargs: Any) -> NoReturn:
            raise TypeError(f"{function.__module__}.{function.__name__} is for kernels only")

        # numba would call the missing entry point: no signature is entered for calls from Python,
        # and what looks for one refuses.
        dispatcher._insert = lambda *_: None
        dispatcher._compile_for_args = refuse
        return cast("Callable[P, R]", dispatcher)

    return decorate


_NO_ENTRY: Any = {"no_cpython_wrapper": True}
