"""Compiler options of functions that only fill arrays which they are given.

Such a function owns no array, so it need not count references, which took more than half of the
time of a search: all tables of a scene are counted at every call.
"""

from __future__ import annotations

from typing import Literal, TypedDict, cast


class KernelOptions(TypedDict, total=False):
    """The options that numba's type hints know; ``_nrt`` is not among them."""

    cache: bool
    error_model: Literal["numpy"]
    forceinline: bool


_OPTIONS = {"cache": True, "error_model": "numpy", "_nrt": False}
KERNEL = cast("KernelOptions", _OPTIONS)
"""For ``numba.njit``; such a function must not create arrays, nor assign one array to another."""
INNER = cast("KernelOptions", {**_OPTIONS, "forceinline": True})
"""For functions inside a rollout: a call would copy all tables of the scene."""
