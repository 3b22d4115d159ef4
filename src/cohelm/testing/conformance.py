"""What every check has in common: require, twice the same, inputs untouched, in time."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from cohelm.arrays import identical
from cohelm.errors import CohelmError

_T = TypeVar("_T")

TOLERANCE = 1e-6
"""Rounding allowed where a limit must hold, SI."""


class ConformanceError(AssertionError):
    """A part breaks its contract; the message says how."""


def require(kept: Any, what: str) -> None:
    """Raise :class:`ConformanceError` saying ``what`` unless ``kept``; arrays must be all true."""
    if not np.all(kept):
        raise ConformanceError(what)


def require_finite(values: Mapping[str, Any]) -> None:
    """Every array named in ``values`` holds numbers only, neither NaN nor infinite."""
    for name, array in values.items():
        require(np.isfinite(array), f"{name} must be finite, got {np.asarray(array)!r}")


def require_raises(error: type[CohelmError], call: Callable[[], Any], when: str) -> None:
    """``call`` raises exactly the typed ``error``, no parent of it and no other."""
    try:
        got = call()
    except CohelmError as raised:
        require(
            isinstance(raised, error),
            f"{when}: must raise {error.__name__}, raised {type(raised).__name__}: {raised}",
        )
        return
    except Exception as raised:
        raise ConformanceError(
            f"{when}: must raise {error.__name__}, raised {type(raised).__name__}: {raised}"
        ) from raised
    raise ConformanceError(f"{when}: must raise {error.__name__}, returned {type(got).__name__}")


def steady(call: Callable[[], _T], *, inputs: Any, what: str, within: float) -> _T:
    """The result of ``call``, which must give it twice, bit for bit, leave ``inputs`` and be quick.

    Args:
        call: without arguments; a generator that it draws from must be made inside it.
        inputs: every value that the call is given.
        what: named in the error, as ``plan``.
        within: thread CPU time allowed to the second call, s. Generous: it finds a part that
            hangs, not one that is slow; the first call, which may compile, is free.

    Raises:
        ConformanceError: naming which of these was broken.
    """
    before = _snapshot(inputs)
    first = _snapshot(call())
    started = time.thread_time()
    again = call()
    spent = time.thread_time() - started
    require(identical(before, _snapshot(inputs)), f"{what} must leave its arguments as they were")
    require(identical(first, _snapshot(again)), f"{what} must give the same for the same arguments")
    require(spent <= within, f"{what} took {spent:.2f} s of CPU time, allowed are {within:.2f} s")
    return again


def _snapshot(given: Any) -> Any:
    """A deep copy that keeps what ``identical`` compares, also of values that cannot be pickled."""
    if isinstance(given, np.ndarray):
        return given.copy()
    if dataclasses.is_dataclass(given) and not isinstance(given, type):
        fields = {f.name: _snapshot(getattr(given, f.name)) for f in dataclasses.fields(given)}
        return (type(given), fields)
    if isinstance(given, Mapping):
        return {key: _snapshot(item) for key, item in given.items()}
    if isinstance(given, tuple | list):
        return tuple(_snapshot(item) for item in given)
    return given
