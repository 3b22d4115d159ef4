"""Executor on Dask distributed: a cluster on this machine, or many machines.

A worker does one task at a time in a temporary folder. The files that the task writes there are
returned with the results, so no folder has to be shared. A worker with other code than this process
ends the sweep.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import logging
import pickle
import tempfile
import threading
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from cohelm.errors import ConfigError
from cohelm.evaluation.code_version import code, code_digest, differences
from cohelm.evaluation.sweeps.executors import (
    RETRIES,
    Executor,
    Numbered,
    WorkersFailed,
    do,
)
from cohelm.evaluation.sweeps.tasks import CompletedTask, Task, TaskError, Work
from cohelm.processes import without_interrupts

LOCAL = "local"
ANSWER, FIRST_WORKER = 5.0, 10.0
"""Timeouts of a scheduler and of its first worker, s."""

_one_at_a_time = threading.Lock()


@dataclass(frozen=True)
class _Returned:
    """Return value of a worker."""

    done: CompletedTask | None
    """None: the worker has other code."""
    files: Mapping[str, bytes]
    """Files of the task, by their path in the folder."""
    code: Mapping[str, str]
    """Code of the worker, where it differs."""


@contextmanager
def on_dask(address: str, workers: int) -> Iterator[Executor]:
    """Provide an executor on Dask.

    Args:
        address: address of a scheduler, as ``tcp://host:8786``; ``local``: start a cluster here.
        workers: number of workers of a cluster that is started here.

    Raises:
        ConfigError: if Dask is not installed.
        WorkersFailed: if there is no such scheduler, or no suitable worker.
    """
    try:
        distributed = import_module("distributed")
        config = import_module("dask").config
    except ImportError:
        raise ConfigError(
            "Dask distributed is not installed: pip install 'cohelm[cluster]'", key="--cluster"
        ) from None
    with (
        _quiet(logging.getLogger("distributed")),
        config.set({"distributed.scheduler.allowed-failures": RETRIES}),
        closing(_connect(distributed, address, workers)) as connection,
    ):
        _check(connection.client, address)
        yield connection.run


@contextmanager
def _quiet(log: logging.Logger) -> Iterator[None]:
    """Silence the log: workers may die and come back."""
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(level)


class _Dask:
    """Scheduler that holds one task for each worker."""

    def __init__(self, client: Any, cluster: Any, address: str) -> None:
        self.client, self._cluster, self._address = client, cluster, address

    def close(self) -> None:
        """Disconnect; end a cluster that was started here."""
        for each in (self.client, self._cluster):
            if each is not None:
                with suppress(OSError, TimeoutError):
                    each.close(timeout=ANSWER)

    def run(
        self, work: Work, folder: Path, tasks: Sequence[Numbered]
    ) -> Generator[CompletedTask, None, None]:
        """Do tasks, as an executor."""
        distributed: Any = import_module("distributed")
        job, digest = pickle.dumps(work), code_digest()
        waiting = iter(tasks)
        running: dict[Any, int] = {}
        ended = distributed.as_completed(loop=self.client.loop)
        try:
            while True:
                for index, task in islice(waiting, max(self._workers() - len(running), 0)):
                    future = self.client.submit(_remotely, job, digest, index, task, pure=False)
                    running[future] = index
                    ended.add(future)
                if not running:
                    return
                future = next(ended)
                yield self._done(future, running.pop(future), folder)
        finally:
            with suppress(OSError, TimeoutError):
                self.client.cancel(list(running), force=True)

    def _workers(self) -> int:
        """Number of workers; one where all have just died."""
        try:
            return max(len(self.client.nthreads()), 1)
        except (OSError, TimeoutError):
            raise self._gone() from None

    def _done(self, future: Any, index: int, folder: Path) -> CompletedTask:
        if future.status == "cancelled":
            raise self._gone()
        try:
            failure = future.exception()
            returned: _Returned | None = None if failure else future.result()
        except (OSError, TimeoutError, asyncio.CancelledError, concurrent.futures.CancelledError):
            raise self._gone() from None
        if isinstance(failure, import_module("distributed").KilledWorker):
            error = TaskError(f"its worker died, {RETRIES + 1} times")
            return CompletedTask(index, (), error)
        if failure is not None:
            raise WorkersFailed(f"{self._address}: a worker cannot do the tasks: {failure}")
        if returned is None:
            raise self._gone()
        if returned.done is None:
            other = differences(code(), returned.code)
            raise WorkersFailed(f"{self._address}: a worker runs other code ({other})")
        for name, content in returned.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        return returned.done

    def _gone(self) -> WorkersFailed:
        return WorkersFailed(f"{self._address}: the scheduler went away; --resume continues")


def _connect(distributed: Any, address: str, workers: int) -> _Dask:
    if address == LOCAL:
        with without_interrupts():  # its workers must not receive an interrupt of this process
            cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address=None,
                memory_limit=0,
                silence_logs=logging.CRITICAL,
            )
        return _Dask(distributed.Client(cluster, set_as_default=False), cluster, "local cluster")
    try:
        client = distributed.Client(address, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as cause:
        raise WorkersFailed(
            f"{address}: no Dask scheduler answers there ({type(cause).__name__}); "
            "start one with: dask scheduler"
        ) from None
    return _Dask(client, None, address)


def _check(client: Any, address: str) -> None:
    """Check that there are workers, with cohelm and the same Python.

    Their code is checked with each task, because workers may come later.
    """
    try:
        client.wait_for_workers(1, timeout=FIRST_WORKER)
    except TimeoutError:
        raise WorkersFailed(
            f"{address}: the scheduler has no workers; start some with: "
            "dask worker ADDRESS --nthreads 1"
        ) from None
    found = client.get_versions(packages=["cohelm"])
    here = found["client"]
    for worker, there in found["workers"].items():
        if there["packages"]["cohelm"] is None:
            raise WorkersFailed(f"{worker}: cohelm is not installed for this worker")
        python = [each["host"]["python"].split(".")[:2] for each in (here, there)]
        if python[0] != python[1]:
            one, other = (".".join(each) for each in python)
            raise WorkersFailed(f"{worker}: this worker runs Python {other}, not {one}")


def _remotely(job: bytes, digest: str, index: int, task: Task) -> _Returned:
    """Do one task, in the process of a worker."""
    if code_digest() != digest:
        return _Returned(None, {}, code())
    with _one_at_a_time, tempfile.TemporaryDirectory(prefix="cohelm-") as name:
        folder = Path(name)
        done = do(pickle.loads(job), folder, index, task)
        files = [file for file in sorted(folder.rglob("*")) if file.is_file()]
        return _Returned(
            done, {file.relative_to(folder).as_posix(): file.read_bytes() for file in files}, {}
        )
