"""How far a benchmark has come: a bar on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import math
import time
from types import TracebackType

from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as RichProgress

from cohelm.cli.report import ERRORS
from cohelm.evaluation.sweeps.tasks import Progress

EVERY = 20.0
"""Between two lines where there is no terminal, s."""


class Bar:
    """Shows the progress of a sweep on standard error.

    Args:
        name: of the benchmark.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._last = time.monotonic()
        self._bar = RichProgress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[left]}"),
            console=ERRORS,
            transient=True,
            disable=not ERRORS.is_terminal,
        )
        self._task = self._bar.add_task(name, total=None, left="")

    def __enter__(self) -> Bar:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def __call__(self, progress: Progress) -> None:
        """Show it."""
        says = left_of(progress)
        self._bar.update(
            self._task, total=progress.total, completed=progress.done, left=says, refresh=True
        )
        now = time.monotonic()
        if not ERRORS.is_terminal and now - self._last > EVERY:
            self._last = now
            line = f"{self._name}: {progress.done} of {progress.total}, {says}"
            ERRORS.print(line, markup=False, soft_wrap=True)


def left_of(progress: Progress) -> str:
    """The time that is left, and what failed, in words."""
    left = progress.left
    says = "compiling, riding …" if math.isnan(left) else f"about {_span(left)} left"
    return f"{says}, {progress.failed} failed" if progress.failed else says


def _span(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
