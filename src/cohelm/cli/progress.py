"""What is seen on standard error while something runs that takes its time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
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

from cohelm.cli import compiled_code
from cohelm.cli.report import ERRORS
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.messages import Reason
from cohelm.navigation import Tick
from cohelm.simulation import Truth

Thing = TypeVar("Thing")

COMPILING = 3.0
"""Preparation that takes longer than this compiles, s."""


def _live(render: Callable[[], RenderableType]) -> Live:
    """Something on standard error that changes, and is gone at the end."""
    return Live(
        get_renderable=render,
        console=ERRORS,
        refresh_per_second=5,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )


class RideProgress:
    """A watcher of a ride that shows it live: speed, η, nearest gap, last stop, what is left.

    Args:
        title: of the ride.
        time_limit: s.
        shown: whether anything is shown at all.
    """

    def __init__(self, title: str, time_limit: float, *, shown: bool) -> None:
        self._title = title
        self._limit = time_limit
        self._began = time.monotonic()
        self._spinner = Spinner("dots")
        self._last: tuple[Tick, Truth] | None = None
        self._reason: Reason | None = None
        self._shown = shown and ERRORS.is_terminal
        self._compiles = shown and not compiled_code.is_there()
        self._live = _live(self._render)

    def __enter__(self) -> Self:
        if self._shown:
            self._live.start()
        elif self._compiles:
            ERRORS.print(f"{compiled_code.COMPILING} …")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._shown:
            self._live.stop()

    def __call__(self, tick: Tick, truth: Truth) -> None:
        """One more tick."""
        self._last = tick, truth
        if tick.decision.reason not in {None, Reason.ARRIVED}:
            self._reason = tick.decision.reason

    def _render(self) -> Group | Spinner:
        if self._last is None:
            waited = time.monotonic() - self._began
            compiles = self._compiles or waited > COMPILING
            what = compiled_code.COMPILING if compiles else "setting the stage"
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
            f"nearest {gap:4.2f} m" if np.isfinite(gap) else "nobody there",
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


def _along(tick: Tick, truth: Truth) -> tuple[float, float]:
    """(length driven, whole length) of the present route, m."""
    if tick.path is None:
        return 0.0, 0.0
    points = np.ascontiguousarray(tick.path.points)
    along, _ = nearest_on_polyline(points, float(truth.pose[0]), float(truth.pose[1]))
    return along, float(arc_length(points)[-1])


PATIENCE = 2.0
"""Nobody is told to wait for less, s."""


class Waiting:
    """A line on a terminal while something takes longer than two seconds.

    Args:
        what: is being done.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._began = time.monotonic()
        self._spinner = Spinner("dots")
        self._live = _live(self._render)

    def __enter__(self) -> Self:
        if ERRORS.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *what: object) -> None:
        if ERRORS.is_terminal:
            self._live.stop()

    def _render(self) -> Spinner | Text:
        waited = time.monotonic() - self._began
        if waited < PATIENCE:
            return Text("")
        note = ", compiling on the first run" if waited > 2.0 * COMPILING else ""
        self._spinner.update(text=Text(f"{self._what} … {waited:.0f} s{note}"))
        return self._spinner


class Counting:
    """A bar on a terminal while things are gone through, gone at the end.

    Args:
        what: is being gone through.
        total: how many there are; None: not known.
        shown: whether anything is shown at all.
    """

    def __init__(self, what: str, total: int | None, *, shown: bool = True) -> None:
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
        self._task = self._bar.add_task(what, total=total)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *what: object) -> None:
        self._bar.stop()

    def __call__(self, things: Iterable[Thing]) -> Iterator[Thing]:
        """The same things, counted once they are done with."""
        for thing in things:
            yield thing
            self._bar.advance(self._task)
