"""Tasks of a sweep, their results and errors, and its progress."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cohelm.arrays import Floats

Task = tuple[Any, ...]
"""Plain values, or frozen values of them, for a worker."""


@dataclass(frozen=True)
class Result:
    """One result of a task."""

    row: Mapping[str, Any]
    """Text and numbers, a row of the table of all results; NaN: does not apply."""
    arrays: Mapping[str, Floats] = field(default_factory=dict)
    """Arrays for the pictures of the report."""


@dataclass(frozen=True)
class TaskError:
    """Error that ended a task."""

    error: str
    """One line: the exception, or how the process ended."""
    traceback: str = ""
    """Traceback of the exception; empty where a process died."""

    @classmethod
    def of(cls, failure: BaseException) -> TaskError:
        """Error of an exception, cut to what a table can hold.

        Raises:
            KeyboardInterrupt: if that is its cause: interrupted compiled code raises a
                ``SystemError``, and the task is not done.
        """
        if isinstance(failure.__cause__, KeyboardInterrupt):
            raise KeyboardInterrupt from failure
        text = (str(failure).splitlines() or [""])[0]
        where = "".join(traceback.format_exception(failure))
        return cls(f"{type(failure).__name__}: {text}"[:300], where[-4000:])


Work = Callable[[Any, Path], Sequence[Result]]
"""Function that does one task and may write files to the folder."""


@dataclass(frozen=True)
class CompletedTask:
    """Results of one task, or its error."""

    index: int
    """Index of the task."""
    results: Sequence[Result]
    error: TaskError | None = None


@dataclass(frozen=True)
class SweepState:
    """Progress of a sweep."""

    done: int
    total: int
    seconds: float
    """Time since the start, s."""
    before: int = 0
    """Tasks that were done at the start."""
    failed: int = 0

    @property
    def left(self) -> float:
        """Estimated remaining time, s; NaN before the first result."""
        now = self.done - self.before
        return self.seconds / now * (self.total - self.done) if now else math.nan
