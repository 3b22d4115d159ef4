"""What a benchmark is: tasks from seeds, rows from each task, a report from the rows.

A benchmark is a module with the names of :class:`Bench`; one line in
``cohelm.cli.benches.BENCHES`` makes it a command. Rows are written as they come, so that
whoever interrupts it keeps what there is.
"""

from __future__ import annotations

import csv
import math
import multiprocessing
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from cohelm.arrays import Floats
from cohelm.errors import ConfigError

Task = tuple[Any, ...]
"""Plain values that a worker understands."""


@dataclass(frozen=True)
class Result:
    """One thing that came of a task."""

    row: Mapping[str, Any]
    """Words and numbers, a line of the table of all results; NaN: no meaning here."""
    arrays: Mapping[str, Floats] = field(default_factory=dict)
    """What the report's pictures need."""


@dataclass(frozen=True)
class Sheet:
    """A table for people."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Report:
    """What the results say."""

    sheets: tuple[Sheet, ...]
    notes: tuple[str, ...]
    """Sentences: what was met, what was missed, what could not be run."""
    summary: Mapping[str, Any]
    """The same for programs."""
    files: tuple[Path, ...] = ()
    """What was written beyond the rows."""


def parted(names: str | None, key: str) -> tuple[str, ...]:
    """Names that an option lists with commas; none where it is not given.

    Args:
        names: what was written; None: nothing was.
        key: the option.

    Raises:
        ConfigError: if it is given and names nothing: it does not mean everything then.
    """
    found = tuple(name.strip() for name in (names or "").split(",") if name.strip())
    if names is not None and not found:
        raise ConfigError(f"names nothing ({names!r}); leave it out for the usual ones", key=key)
    return found


class Bench(Protocol):
    """A benchmark; a module is one."""

    TITLE: str
    SEEDS: int
    """How many seeds where no number is asked for."""
    WORKERS: int | None
    """How many processes; None: as many as there are processors. Who measures time takes one."""

    def tasks(self, seeds: range) -> Sequence[Task]:
        """What is to be done, in the order of the table."""
        ...

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Do one task, in a process of its own; the same task gives the same rows, timing apart."""
        ...

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """What the results there are say; writes pictures to the folder."""
        ...


@dataclass(frozen=True)
class Progress:
    """How far a benchmark has come."""

    done: int
    total: int
    seconds: float
    """Since it began, s."""

    @property
    def left(self) -> float:
        """Time that is probably left, s; NaN before the first result."""
        return self.seconds / self.done * (self.total - self.done) if self.done else math.nan


def run_tasks(
    bench: Bench,
    tasks: Sequence[Task],
    folder: Path,
    *,
    workers: int,
    watch: Callable[[Progress], None] = lambda progress: None,
) -> list[Result]:
    """The results in the order of the tasks; ``rows.csv`` in the folder grows with them.

    An interrupt ends it: what is done by then is returned.
    """
    began = time.monotonic()
    done: dict[int, Sequence[Result]] = {}
    watch(Progress(0, len(tasks), 0.0))
    try:
        for index, each in _results(bench, tasks, folder, min(workers, len(tasks))):
            done[index] = each
            write_rows([result.row for result in _in_order(done)], folder / "rows.csv")
            watch(Progress(len(done), len(tasks), time.monotonic() - began))
    except KeyboardInterrupt:
        pass
    return _in_order(done)


def write_rows(rows: Sequence[Mapping[str, Any]], file: Path) -> None:
    """Rows as a table; the columns are those of the first."""
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(rows[0])
        for row in rows:
            writer.writerow([_cell(row.get(key)) for key in rows[0]])


def _in_order(done: Mapping[int, Sequence[Result]]) -> list[Result]:
    return [result for index in sorted(done) for result in done[index]]


def _cell(content: Any) -> Any:
    if isinstance(content, float):
        return f"{content:.6g}" if math.isfinite(content) else ""
    return content


def _results(
    bench: Bench, tasks: Sequence[Task], folder: Path, workers: int
) -> Iterator[tuple[int, Sequence[Result]]]:
    work = partial(_one, bench.work, folder)
    if workers <= 1:
        yield from map(work, enumerate(tasks))
        return
    context = multiprocessing.get_context("spawn")  # numba's threads do not survive a fork
    with context.Pool(workers, initializer=_heed_no_interrupt) as pool:  # ended on leaving
        yield from pool.imap_unordered(work, list(enumerate(tasks)))


def _one(
    work: Callable[[Task, Path], Sequence[Result]], folder: Path, numbered: tuple[int, Task]
) -> tuple[int, Sequence[Result]]:
    index, task = numbered
    return index, work(task, folder)


def _heed_no_interrupt() -> None:
    """It is for the process that the workers belong to."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
