"""Progress on standard error while something runs for a while."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Self, TypeVar

import numpy as np
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Column

from cohelm import kernel_cache
from cohelm.cli.report import ERRORS
from cohelm.evaluation.sweeps.tasks import SweepState
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.messages import Reason
from cohelm.navigation import Tick
from cohelm.simulation import GroundTruth

Thing = TypeVar("Thing")

COMPILING = "compiling for this machine, once; it takes a minute or more"


def _progress(*columns: ProgressColumn, shown: bool = True) -> Progress:
    """Live display on standard error, if that is a terminal, that disappears at the end."""
    return Progress(
        *columns,
        console=ERRORS,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
        disable=not (shown and ERRORS.is_terminal),
    )


def _text(words: str = "{task.description}") -> TextColumn:
    return TextColumn(words, markup=False)


class RideProgress:
    """Live display of a ride: speed, η, nearest person, last stop, remaining distance and time.

    Args:
        title: Title of the ride.
        time_limit: s.
        shown: False: show nothing.
    """

    def __init__(self, title: str, time_limit: float, *, shown: bool) -> None:
        self._limit = time_limit
        self._reason: Reason | None = None
        self._compiles = shown and not kernel_cache.is_filled()
        # A plain column folds what a narrow terminal does not hold.
        facts = TextColumn("{task.fields[facts]}", markup=False, table_column=Column())
        columns = (SpinnerColumn(), _text(), BarColumn(bar_width=20), facts)
        self._bar = _progress(*columns, shown=shown)
        what = COMPILING if self._compiles else "building the scenario"
        self._task = self._bar.add_task(title, total=None, facts=f"{what} …")

    def __enter__(self) -> Self:
        self._bar.start()
        if self._compiles and self._bar.disable:
            ERRORS.print(f"{COMPILING} …")
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def __call__(self, tick: Tick, truth: GroundTruth) -> None:
        """Show one more tick."""
        if self._bar.disable:
            return
        if tick.decision.reason not in {None, Reason.ARRIVED}:
            self._reason = tick.decision.reason
        gap = float(truth.gap_people.min(initial=np.inf).clip(min=0.0))
        eta = tick.authority.eta if tick.authority is not None else 0.0
        driven, total = _along(tick, truth)
        facts = [
            f"{truth.time:5.1f} s",
            f"speed {truth.twist[0]:4.2f} m/s",
            f"η {eta:4.2f}",
            f"nearest {gap:4.2f} m" if np.isfinite(gap) else "no people",
            f"{max(total - driven, 0.0):4.1f} m to go",
            f"{self._limit - truth.time:3.0f} s left",
            f"last stop: {self._reason.sentence if self._reason is not None else '—'}",
        ]
        self._bar.update(
            self._task, total=max(total, 1e-6), completed=driven, facts="   ".join(facts)
        )


def _along(tick: Tick, truth: GroundTruth) -> tuple[float, float]:
    """(length driven, total length) of the current route, m."""
    if tick.path is None:
        return 0.0, 0.0
    points = np.ascontiguousarray(tick.path.points)
    along, _ = nearest_on_polyline(points, float(truth.pose[0]), float(truth.pose[1]))
    return along, float(arc_length(points)[-1])


@contextmanager
def waiting(activity: str) -> Iterator[None]:
    """Show an activity and its duration on a terminal."""
    with _progress(SpinnerColumn(), _text(), TimeElapsedColumn()) as bar:
        bar.add_task(f"{activity} …")
        yield


class Counting:
    """Progress bar on a terminal over an iterable.

    Args:
        name: Name of the iterable.
        total: Number of elements; None: unknown.
        shown: False: show nothing.
    """

    def __init__(self, name: str, total: int | None, *, shown: bool = True) -> None:
        columns = (SpinnerColumn(), _text(), BarColumn(), MofNCompleteColumn())
        self._bar = _progress(*columns, TimeRemainingColumn(), shown=shown)
        self._task = self._bar.add_task(name, total=total)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def __call__(self, things: Iterable[Thing]) -> Iterator[Thing]:
        """Yield the elements, each counted when the next is requested."""
        for thing in things:
            yield thing
            self._bar.advance(self._task)


LINE_INTERVAL = 20.0
"""Interval of progress lines where there is no terminal, s."""


class SweepProgress:
    """Progress of a sweep on standard error.

    Args:
        name: Name of the benchmark.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._last = time.monotonic()
        columns = (_text(), BarColumn(), MofNCompleteColumn(), _text("{task.fields[left]}"))
        self._bar = _progress(*columns)
        self._task = self._bar.add_task(name, total=None, left="")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def __call__(self, progress: SweepState) -> None:
        """Show the new state."""
        text = remaining(progress)
        self._bar.update(
            self._task, total=progress.total, completed=progress.done, left=text, refresh=True
        )
        now = time.monotonic()
        if not ERRORS.is_terminal and now - self._last > LINE_INTERVAL:
            self._last = now
            line = f"{self._name}: {progress.done} of {progress.total}, {text}"
            ERRORS.print(line, markup=False, soft_wrap=True)


def remaining(progress: SweepState) -> str:
    """Remaining time and number of failed tasks, in words."""
    left = progress.left
    text = "compiling and simulating …" if math.isnan(left) else f"about {_span(left)} left"
    return f"{text}, {progress.failed} failed" if progress.failed else text


def _span(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
