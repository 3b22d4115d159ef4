"""Tasks done in any order, kept as they come, and given back in the order they were asked for."""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps.asked import Asked
from cohelm.evaluation.sweeps.executors import Executor, in_processes
from cohelm.evaluation.sweeps.identity import keys_of
from cohelm.evaluation.sweeps.ledger import EPISODES, Ledger, Record
from cohelm.evaluation.sweeps.ride_task import failed_rides, rides_in
from cohelm.evaluation.sweeps.tasks import Done, Fault, Progress, Result, Task

Watch = Callable[[Progress], None]
_SHARE = 20.0
"""Rows are written when that took less than this part of the time since."""
_RARELY = 1.0  # s


class Worker(Protocol):
    """The part of a benchmark that a sweep needs."""

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Do one task."""
        ...


@dataclass(frozen=True)
class Sweep:
    """What came of a sweep."""

    results: list[Result]
    """In the order of the tasks."""
    faults: Mapping[int, Fault]
    """Of the tasks, by number, that raised or whose process died."""
    done: int
    total: int

    @property
    def whole(self) -> bool:
        """Whether every task was tried."""
        return self.done == self.total


def sweep(
    bench: Worker,
    tasks: Sequence[Task],
    folder: Path,
    *,
    executor: Executor,
    ledger: Ledger | None = None,
    watch: Watch = lambda progress: None,
) -> Sweep:
    """Do those tasks that the ledger does not have; ``rows.csv`` in the folder grows.

    Tasks that failed before are tried again; a ride that failed is a row all the same. An
    interrupt ends it: what is done by then is returned. The results are those the ledger gives
    back, so that a sweep that went on is the same as one that was never interrupted.

    Raises:
        ConfigError: if the ledger cannot be written to.
        WorkersFailed: if there are no workers, or not the right ones.
    """
    keys = keys_of(tasks) if ledger else []
    records = _known(keys, ledger)
    missing = [(i, task) for i, task in enumerate(tasks) if _is_open(records.get(i), ledger)]
    if missing and ledger and ledger.changed:
        raise ConfigError(
            f"{folder} was begun with other code ({ledger.changed}), and {len(missing)} of "
            f"{len(tasks)} tasks are left: go on with the code of then, or begin in another folder",
            key="--resume",
        )
    if ledger:
        ledger.ask(Asked(len(tasks), sum(map(rides_in, tasks))))
    file = _Rows(folder / "rows.csv")
    tally = _Tally(records, len(tasks), before=len(tasks) - len(missing))
    watch(tally.progress())
    try:
        for done in _done(bench, missing, folder, executor):
            record = _kept(tasks, keys, ledger, done)
            tally.count(records.get(done.index), record)
            records[done.index] = record
            (folder / EPISODES).unlink(missing_ok=True)  # it lacks this one
            file.write_now_and_then(records)
            watch(tally.progress())
    except KeyboardInterrupt:
        pass
    except BaseException:
        with suppress(OSError):  # it is told what came before
            file.write(records)
        raise
    file.write(records)
    faults = {i: each.fault for i, each in sorted(records.items()) if each.fault is not None}
    return Sweep(_in_order(records), faults, len(records), len(tasks))


def run_tasks(
    bench: Worker,
    tasks: Sequence[Task],
    folder: Path,
    *,
    workers: int,
    watch: Watch = lambda progress: None,
) -> list[Result]:
    """The results in the order of the tasks, nothing kept but ``rows.csv``.

    Raises:
        RuntimeError: if a task failed, with what it raised; the others are done before.
    """
    done = sweep(bench, tasks, folder, executor=in_processes(workers), watch=watch)
    for index, fault in done.faults.items():
        raise RuntimeError(f"task {index}: {fault.error}\n{fault.traceback}")
    return done.results


def write_rows(rows: Sequence[Mapping[str, Any]], file: Path) -> None:
    """Rows as a table that replaces the one there at once; the columns are those of any row."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    beside = file.with_suffix(".part")
    try:
        with beside.open("w", newline="", encoding="utf-8", errors="backslashreplace") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([_cell(row.get(name)) for name in columns] for row in rows)
        beside.replace(file)
    finally:
        beside.unlink(missing_ok=True)


def _known(keys: Sequence[str], ledger: Ledger | None) -> dict[int, Record]:
    there = ledger.records if ledger else {}
    return {i: there[key] for i, key in enumerate(keys) if key in there}


def _is_open(record: Record | None, ledger: Ledger | None) -> bool:
    """Whether a task is to be done; with other code than before, what failed is left alone."""
    changed = ledger is not None and bool(ledger.changed)
    return record is None or (record.fault is not None and not changed)


def _done(
    bench: Worker, missing: Sequence[tuple[int, Task]], folder: Path, executor: Executor
) -> Iterator[Done]:
    if missing:
        with closing(executor(bench.work, folder, missing)) as each:
            yield from each


def _kept(tasks: Sequence[Task], keys: Sequence[str], ledger: Ledger | None, done: Done) -> Record:
    results, fault = done.results, done.fault
    if fault is not None:
        results = failed_rides(tasks[done.index], fault)
    if ledger is None:
        return Record(tuple(results), fault)
    try:
        return ledger.add(keys[done.index], results, fault)
    except TypeError as failure:  # a row of things that no file holds
        return ledger.add(keys[done.index], (), Fault.of(failure))


def _in_order(records: Mapping[int, Record]) -> list[Result]:
    return [result for index in sorted(records) for result in records[index].results]


class _Tally:
    """How many tasks are done and failed, counted as they come; ``before``: at the begin."""

    def __init__(self, records: Mapping[int, Record], total: int, *, before: int) -> None:
        self._failed = sum(each.fault is not None for each in records.values())
        self._total, self._before, self._done = total, before, before
        self._began = time.monotonic()

    def count(self, old: Record | None, new: Record) -> None:
        """One more is done; ``old`` is what came of it before."""
        self._done += 1
        self._failed += new.fault is not None
        self._failed -= old is not None and old.fault is not None

    def progress(self) -> Progress:
        seconds = time.monotonic() - self._began
        return Progress(self._done, self._total, seconds, self._before, self._failed)


class _Rows:
    """The table of the rows, written anew as rarely as it takes time."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._cost, self._last = 0.0, -math.inf

    def write_now_and_then(self, records: Mapping[int, Record]) -> None:
        if time.monotonic() - self._last > max(_SHARE * self._cost, _RARELY):
            self.write(records)

    def write(self, records: Mapping[int, Record]) -> None:
        began = time.monotonic()
        rows = [result.row for result in _in_order(records)]
        if rows:
            write_rows(rows, self._file)
        self._last = time.monotonic()
        self._cost = self._last - began


def _cell(content: Any) -> Any:
    if isinstance(content, float):
        return f"{content:.6g}" if math.isfinite(content) else ""
    return content
