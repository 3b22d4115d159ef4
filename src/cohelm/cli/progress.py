"""Progress on standard error while something runs for a while."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Self, TypeVar

import numpy as np
from rich.console import Group, RenderableType
from rich.live import Live
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeRemainingColumn,
)
from rich.progress_bar import ProgressBar
from rich.spinner import Spinner
from rich.text import Text

from cohelm import kernel_cache
from cohelm.cli.report import ERRORS
from cohelm.evaluation.sweeps.tasks import SweepState
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.messages import Reason
from cohelm.navigation import Tick
from cohelm.simulation import GroundTruth

Thing = TypeVar("Thing")

COMPILING = "compiling for this machine, once; it takes a minute or more"
USUAL = 3.0
"""Preparation that takes longer than this is compilation, s."""


def _live(render: Callable[[], RenderableType]) -> Live:
    """Live display on standard error that disappears at the end."""
    return Live(
        get_renderable=render,
        console=ERRORS,
        refresh_per_second=5,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )


class RideProgress:
    """Live display of a ride: speed, η, nearest person, last stop, remaining distance and time.

    Args:
        title: Title of the ride.
        time_limit: s.
        shown: False: show nothing.
    """

    def __init__(self, title: str, time_limit: float, *, shown: bool) -> None:
        self._title = title
        self._limit = time_limit
        self._began = time.monotonic()
        self._spinner = Spinner("dots")
        self._last: tuple[Tick, GroundTruth] | None = None
        self._reason: Reason | None = None
        self._shown = shown and ERRORS.is_terminal
        self._compiles = shown and not kernel_cache.is_filled()
        self._live = _live(self._render)

    def __enter__(self) -> Self:
        if self._shown:
            self._live.start()
        elif self._compiles:
            ERRORS.print(f"{COMPILING} …")
        return self

    def __exit__(self, *error: object) -> None:
        if self._shown:
            self._live.stop()

    def __call__(self, tick: Tick, truth: GroundTruth) -> None:
        """Show one more tick."""
        self._last = tick, truth
        if tick.decision.reason not in {None, Reason.ARRIVED}:
            self._reason = tick.decision.reason

    def _render(self) -> Group | Spinner:
        if self._last is None:
            waited = time.monotonic() - self._began
            compiles = self._compiles or waited > USUAL
            what = COMPILING if compiles else "building the scenario"
            self._spinner.update(text=Text(f"{self._title}: {what} …"))
            return self._spinner
        tick, truth = self._last
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
        ]
        last = self._reason.sentence if self._reason is not None else "—"
        return Group(
            Text(self._title, style="bold"),
            ProgressBar(total=max(total, 1e-6), completed=driven, width=60),
            Text("   ".join(facts)),
            Text(f"last stop: {last}", style="dim"),
        )


def _along(tick: Tick, truth: GroundTruth) -> tuple[float, float]:
    """(length driven, total length) of the current route, m."""
    if tick.path is None:
        return 0.0, 0.0
    points = np.ascontiguousarray(tick.path.points)
    along, _ = nearest_on_polyline(points, float(truth.pose[0]), float(truth.pose[1]))
    return along, float(arc_length(points)[-1])


PATIENCE = 2.0
"""Shorter waits are not shown, s."""


class Waiting:
    """Line on a terminal while something takes longer than two seconds.

    Args:
        activity: Name of the activity.
    """

    def __init__(self, activity: str) -> None:
        self._activity = activity
        self._began = time.monotonic()
        self._spinner = Spinner("dots")
        self._live = _live(self._render)

    def __enter__(self) -> Self:
        if ERRORS.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *error: object) -> None:
        if ERRORS.is_terminal:
            self._live.stop()

    def _render(self) -> Spinner | Text:
        waited = time.monotonic() - self._began
        if waited < PATIENCE:
            return Text("")
        note = ", compiling on the first run" if waited > 2.0 * USUAL else ""
        self._spinner.update(text=Text(f"{self._activity} … {waited:.0f} s{note}"))
        return self._spinner


class Counting:
    """Progress bar on a terminal over an iterable.

    Args:
        name: Name of the iterable.
        total: Number of elements; None: unknown.
        shown: False: show nothing.
    """

    def __init__(self, name: str, total: int | None, *, shown: bool = True) -> None:
        self._bar = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=ERRORS,
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
            disable=not (shown and ERRORS.is_terminal),
        )
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
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[left]}"),
            console=ERRORS,
            transient=True,
            disable=not ERRORS.is_terminal,
        )
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
