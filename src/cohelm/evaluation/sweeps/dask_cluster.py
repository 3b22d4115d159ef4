"""The tasks of a sweep on Dask distributed: on a cluster here, or on many machines.

A worker does one task at a time, whatever its threads, in a folder of its own; the files that the
task writes there come back with the results, so that no folder has to be shared. Who runs other
code than this process is told so instead of being given tasks.
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
from cohelm.evaluation.processes import without_interrupts
from cohelm.evaluation.sweeps.executors import (
    RETRIES,
    Executor,
    Numbered,
    WorkersFailed,
    do,
)
from cohelm.evaluation.sweeps.identity import code, code_digest, differences
from cohelm.evaluation.sweeps.tasks import Done, Fault, Task, Work

LOCAL = "local"
ANSWER, FIRST_WORKER = 5.0, 10.0
"""How long to wait for a scheduler, and for its first worker, s."""

_one_at_a_time = threading.Lock()


@dataclass(frozen=True)
class _Back:
    """What a worker gives back."""

    done: Done | None
    """None: it runs other code."""
    files: Mapping[str, bytes]
    """What the task wrote, by its name in the folder."""
    code: Mapping[str, str]
    """What runs there, where it is not what runs here."""


@contextmanager
def on_dask(address: str, workers: int) -> Iterator[Executor]:
    """Connect to Dask.

    Args:
        address: of a scheduler, as ``tcp://host:8786``; ``local``: one is started here.
        workers: of a cluster that is started here.

    Raises:
        ConfigError: if Dask is not installed.
        WorkersFailed: if there is no such scheduler, or no worker that can do the tasks.
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
    """Workers may die and come back without a word in the log."""
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(level)


class _Dask:
    """A scheduler that is given a task for each worker there is, and another when one is done."""

    def __init__(self, client: Any, cluster: Any, address: str) -> None:
        self.client, self._cluster, self._address = client, cluster, address

    def close(self) -> None:
        """Leave the scheduler; a cluster that was started here ends."""
        for each in (self.client, self._cluster):
            if each is not None:
                with suppress(OSError, TimeoutError):
                    each.close(timeout=ANSWER)

    def run(
        self, work: Work, folder: Path, tasks: Sequence[Numbered]
    ) -> Generator[Done, None, None]:
        """An executor."""
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
        """How many there are; one where all have just died."""
        try:
            return max(len(self.client.nthreads()), 1)
        except (OSError, TimeoutError):
            raise self._gone() from None

    def _done(self, future: Any, index: int, folder: Path) -> Done:
        if future.status == "cancelled":
            raise self._gone()
        try:
            failure = future.exception()
            back: _Back | None = None if failure else future.result()
        except (OSError, TimeoutError, asyncio.CancelledError, concurrent.futures.CancelledError):
            raise self._gone() from None
        if isinstance(failure, import_module("distributed").KilledWorker):
            return Done(index, (), Fault(f"its worker died, {RETRIES + 1} times"))
        if failure is not None:
            raise WorkersFailed(f"{self._address}: a worker cannot do the tasks: {failure}")
        if back is None:
            raise self._gone()
        if back.done is None:
            other = differences(code(), back.code)
            raise WorkersFailed(f"{self._address}: a worker runs other code ({other})")
        for name, content in back.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        return back.done

    def _gone(self) -> WorkersFailed:
        return WorkersFailed(f"{self._address}: the scheduler went away; --resume goes on")


def _connect(distributed: Any, address: str, workers: int) -> _Dask:
    if address == LOCAL:
        with without_interrupts():  # else its workers hear what is for this process
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
    """Whether there are workers, and whether they have cohelm on the same Python.

    What they run is told with each task, for others may come later.
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


def _remotely(job: bytes, digest: str, index: int, task: Task) -> _Back:
    """One task, in the process of a worker."""
    if code_digest() != digest:
        return _Back(None, {}, code())
    with _one_at_a_time, tempfile.TemporaryDirectory(prefix="cohelm-") as name:
        folder = Path(name)
        done = do(pickle.loads(job), folder, index, task)
        files = [file for file in sorted(folder.rglob("*")) if file.is_file()]
        return _Back(
            done, {file.relative_to(folder).as_posix(): file.read_bytes() for file in files}, {}
        )
