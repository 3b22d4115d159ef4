"""Common parts of all checks: requirements, determinism, untouched inputs, time."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from cohelm.arrays import identical
from cohelm.errors import CohelmError
from cohelm.stopwatch import Stopwatch

_T = TypeVar("_T")

TOLERANCE = 1e-6
"""Allowed rounding where a limit must hold, SI."""


class ConformanceError(AssertionError):
    """A part violates its contract; the message tells how."""


def require(holds: Any, message: str) -> None:
    """Raise :class:`ConformanceError` with ``message`` unless all of ``holds`` is true."""
    if not np.all(holds):
        raise ConformanceError(message)


def require_finite(values: Mapping[str, Any]) -> None:
    """Check that every named array is finite."""
    for name, array in values.items():
        require(np.isfinite(array), f"{name} must be finite, got {np.asarray(array)!r}")


def require_raises(error: type[CohelmError], call: Callable[[], Any], when: str) -> None:
    """Check that ``call`` raises the typed ``error`` and no other."""
    try:
        got = call()
    except CohelmError as raised:
        require(
            isinstance(raised, error),
            f"{when}: must raise {error.__name__}, raised {type(raised).__name__}: {raised}",
        )
        return
    except Exception as raised:  # a plugin may raise anything but the typed error
        raise ConformanceError(
            f"{when}: must raise {error.__name__}, raised {type(raised).__name__}: {raised}"
        ) from raised
    raise ConformanceError(f"{when}: must raise {error.__name__}, returned {type(got).__name__}")


def steady(call: Callable[[], _T], *, inputs: Any, what: str, within: float) -> _T:
    """Check that a call is deterministic, leaves its inputs alone and is fast; returns its result.

    Args:
        call: without arguments; it has to create the random generator that it draws from.
        inputs: every value that the call receives.
        what: name in the error, such as ``plan``.
        within: allowed thread CPU time of the second call, s. Generous: it detects a part that
            hangs, not one that is slow. The first call, which may compile, is not timed.

    Raises:
        ConformanceError: naming the violated rule.
    """
    before = _snapshot(inputs)
    first = _snapshot(call())
    watch = Stopwatch()
    again = call()
    spent = watch.elapsed()
    require(identical(before, _snapshot(inputs)), f"{what} must not change its arguments")
    require(
        identical(first, _snapshot(again)), f"{what} must return equal results for equal arguments"
    )
    require(spent <= within, f"{what} took {spent:.2f} s of CPU time, allowed are {within:.2f} s")
    return again


def _snapshot(given: Any) -> Any:
    """Deep copy of everything that ``identical`` compares, also of values without pickling."""
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
