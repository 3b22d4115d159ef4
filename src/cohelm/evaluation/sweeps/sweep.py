"""Run the tasks of a sweep in any order, store each result, and return them in task order."""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps.executors import Executor, in_processes
from cohelm.evaluation.sweeps.identity import task_keys
from cohelm.evaluation.sweeps.ride_task import failed_rides, rides_in
from cohelm.evaluation.sweeps.store import (
    EPISODES,
    ROWS,
    Record,
    SweepSize,
    SweepStore,
    read_records,
)
from cohelm.evaluation.sweeps.tasks import CompletedTask, Result, SweepState, Task, TaskError

Watch = Callable[[SweepState], None]
_SHARE = 20.0
"""Time between two writes of the rows, as a multiple of the time that one takes."""
_RARELY = 1.0
"""Shortest time between two writes of the rows, s."""


class Worker(Protocol):
    """Part of a benchmark that a sweep needs."""

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Do one task."""
        ...


@dataclass(frozen=True)
class SweepResult:
    """Results of a sweep."""

    results: list[Result]
    """In the order of the tasks."""
    errors: Mapping[int, TaskError]
    """Errors by the index of the task."""
    done: int
    total: int

    @property
    def is_complete(self) -> bool:
        """True where every task was tried."""
        return self.done == self.total


@contextmanager
def executor_for(cluster: str | None, workers: int) -> Iterator[Executor]:
    """Provide the executor of a sweep.

    Args:
        cluster: ``local`` for a Dask cluster of so many workers on this machine, or the address of
            a Dask scheduler; None: processes.
        workers: number of processes; a scheduler uses those it has.

    Raises:
        ConfigError: if Dask is not installed.
        WorkersFailed: if the scheduler does not answer, or has no workers.
    """
    if cluster is None:
        yield in_processes(workers)
        return
    from cohelm.evaluation.sweeps.dask_cluster import on_dask  # noqa: PLC0415 # an extra

    with on_dask(cluster, workers) as executor:
        yield executor


def sweep(
    bench: Worker,
    tasks: Sequence[Task],
    folder: Path,
    *,
    executor: Executor,
    store: SweepStore | None = None,
    watch: Watch = lambda progress: None,
) -> SweepResult:
    """Do the tasks that the store does not have; ``rows.csv`` in the folder grows meanwhile.

    Failed tasks are tried again; a failed ride is a row. An interrupt ends the sweep and returns
    what is done. The results are read as from the store: a resumed sweep equals an uninterrupted
    one.

    Raises:
        ConfigError: if the store cannot be written to, or tasks are left and the code has changed.
        WorkersFailed: if there are no workers, or not the right ones.
    """
    keys = task_keys(tasks) if store else []
    records = _known(keys, store.records if store else {})
    missing = [(i, task) for i, task in enumerate(tasks) if _is_open(records.get(i), store)]
    if missing and store and store.changed:
        raise ConfigError(
            f"{folder} was begun with other code ({store.changed}), and {len(missing)} of "
            f"{len(tasks)} tasks are left: continue with that code, or begin in another folder",
            key="--resume",
        )
    if store:
        store.set_size(SweepSize(len(tasks), sum(map(rides_in, tasks))))
    file = _Rows(folder / ROWS)
    tally = _Tally(records, len(tasks), before=len(tasks) - len(missing))
    watch(tally.progress())
    try:
        for done in _done(bench, missing, folder, executor):
            record = _stored(tasks, keys, store, done)
            tally.count(records.get(done.index), record)
            records[done.index] = record
            (folder / EPISODES).unlink(missing_ok=True)  # it lacks this task
            file.write_now_and_then(records)
            watch(tally.progress())
    except KeyboardInterrupt:
        with suppress(ConfigError):  # a record may have been stored and not counted yet
            records |= _known(keys, read_records(store.folder) if store else {})
        (folder / EPISODES).unlink(missing_ok=True)
    except BaseException:
        with suppress(OSError):  # the first error is reported
            file.write(records)
        raise
    file.write(records)
    errors = {i: each.error for i, each in sorted(records.items()) if each.error is not None}
    return SweepResult(_in_order(records), errors, len(records), len(tasks))


def run_tasks(
    bench: Worker,
    tasks: Sequence[Task],
    folder: Path,
    *,
    workers: int,
    watch: Watch = lambda progress: None,
) -> list[Result]:
    """Do all tasks without a store; returns their results in order.

    Raises:
        RuntimeError: if a task failed; the others are done before.
    """
    done = sweep(bench, tasks, folder, executor=in_processes(workers), watch=watch)
    for index, error in done.errors.items():
        raise RuntimeError(f"task {index}: {error.error}\n{error.traceback}")
    return done.results


def write_rows(rows: Sequence[Mapping[str, Any]], file: Path) -> None:
    """Write rows as a CSV file, replaced at once; it has the columns of all rows."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    part = file.with_suffix(".part")
    try:
        with part.open("w", newline="", encoding="utf-8", errors="backslashreplace") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([_cell(row.get(name)) for name in columns] for row in rows)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def _known(keys: Sequence[str], there: Mapping[str, Record]) -> dict[int, Record]:
    return {i: there[key] for i, key in enumerate(keys) if key in there}


def _is_open(record: Record | None, store: SweepStore | None) -> bool:
    """Check that a task is to be done; failed ones are not tried again with other code."""
    changed = store is not None and bool(store.changed)
    return record is None or (record.error is not None and not changed)


def _done(
    bench: Worker, missing: Sequence[tuple[int, Task]], folder: Path, executor: Executor
) -> Iterator[CompletedTask]:
    if missing:
        with closing(executor(bench.work, folder, missing)) as each:
            yield from each


def _stored(
    tasks: Sequence[Task], keys: Sequence[str], store: SweepStore | None, done: CompletedTask
) -> Record:
    results, error = done.results, done.error
    if error is not None:
        results = failed_rides(tasks[done.index], error)
    if store is None:
        return Record(tuple(results), error)
    try:
        return store.add(keys[done.index], results, error)
    except TypeError as failure:  # a row that cannot be stored
        return store.add(keys[done.index], (), TaskError.of(failure))


def _in_order(records: Mapping[int, Record]) -> list[Result]:
    return [result for index in sorted(records) for result in records[index].results]


class _Tally:
    """Count of done and failed tasks."""

    def __init__(self, records: Mapping[int, Record], total: int, *, before: int) -> None:
        self._failed = sum(each.error is not None for each in records.values())
        self._total, self._before, self._done = total, before, before
        self._began = time.monotonic()

    def count(self, old: Record | None, new: Record) -> None:
        """Count one more task; ``old`` is its former record."""
        self._done += 1
        self._failed += new.error is not None
        self._failed -= old is not None and old.error is not None

    def progress(self) -> SweepState:
        seconds = time.monotonic() - self._began
        return SweepState(self._done, self._total, seconds, self._before, self._failed)


class _Rows:
    """CSV file of the rows, rewritten at intervals that depend on the time it takes."""

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
