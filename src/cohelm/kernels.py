"""Compiler options of kernels, so that each compiles once and in little time."""

from __future__ import annotations

from typing import Literal, TypedDict, cast


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
