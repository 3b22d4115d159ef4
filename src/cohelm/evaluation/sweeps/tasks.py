"""What a sweep is made of: tasks, what comes of one, and how far it has come."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cohelm.arrays import Floats

Task = tuple[Any, ...]
"""Plain values, or frozen values of them, that a worker understands."""


@dataclass(frozen=True)
class Result:
    """One thing that came of a task."""

    row: Mapping[str, Any]
    """Words and numbers, a line of the table of all results; NaN: no meaning here."""
    arrays: Mapping[str, Floats] = field(default_factory=dict)
    """What the report's pictures need."""


@dataclass(frozen=True)
class Fault:
    """Why nothing came of a task."""

    error: str
    """In one line: what was raised, or how the process ended."""
    traceback: str = ""
    """Where it was raised; empty where a process died."""

    @classmethod
    def of(cls, failure: BaseException) -> Fault:
        """What was raised, in a line, and where; both cut to what a table can hold.

        Raises:
            KeyboardInterrupt: if that led to it: compiled code that is interrupted raises a
                ``SystemError``, and the task is not done.
        """
        if isinstance(failure.__cause__, KeyboardInterrupt):
            raise KeyboardInterrupt from failure
        said = (str(failure).splitlines() or [""])[0]
        where = "".join(traceback.format_exception(failure))
        return cls(f"{type(failure).__name__}: {said}"[:300], where[-4000:])


Work = Callable[[Any, Path], Sequence[Result]]
"""Does one task; may write files to the folder."""


@dataclass(frozen=True)
class Done:
    """What came of one task."""

    index: int
    """Of the task, from 0."""
    results: Sequence[Result]
    fault: Fault | None = None


@dataclass(frozen=True)
class Progress:
    """How far a sweep has come."""

    done: int
    total: int
    seconds: float
    """Since it began, s."""
    before: int = 0
    """Of those done, how many were done when it began."""
    failed: int = 0

    @property
    def left(self) -> float:
        """Time that is probably left, s; NaN before the first result."""
        now = self.done - self.before
        return self.seconds / now * (self.total - self.done) if now else math.nan
