"""Where the tasks of a sweep are done: in this process, or in processes of its own.

A process that dies is replaced, and the task it was at is tried again, at most twice. Whatever a
task raises comes back as a fault.
"""

from __future__ import annotations

import signal
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from cohelm.errors import CohelmError
from cohelm.evaluation.processes import compiled, leave_interrupts, spawn, without_interrupts
from cohelm.evaluation.sweeps.tasks import Done, Fault, Task, Work

Numbered = tuple[int, Task]
Executor = Callable[[Work, Path, Sequence[Numbered]], Generator[Done, None, None]]
"""Does tasks, each with its index; what is done first comes first."""

RETRIES = 2
"""How often a task is tried again whose process died."""
_FALSE_STARTS = 3
_PATIENCE = 5.0  # s, for a process to end


class WorkersFailed(CohelmError):
    """Processes that do not start, or that are not what the sweep needs."""

    code = "workers"


def do(work: Work, folder: Path, index: int, task: Task) -> Done:
    """Do one task; what it raises is a fault."""
    try:
        return Done(index, tuple(work(task, folder)))
    except (Exception, SystemExit) as failure:  # whatever it is, the others go on
        return Done(index, (), Fault.of(failure))


def serially(work: Work, folder: Path, tasks: Sequence[Numbered]) -> Generator[Done, None, None]:
    """In this process, one after the other."""
    for index, task in tasks:
        yield do(work, folder, index, task)


def in_processes(workers: int) -> Executor:
    """In so many processes of its own; in this one where one is asked for."""

    def run(work: Work, folder: Path, tasks: Sequence[Numbered]) -> Generator[Done, None, None]:
        crew = min(workers, len(tasks))
        if crew <= 1:
            return serially(work, folder, tasks)
        return _Crew(work, folder, tasks).run(crew)

    return run


@contextmanager
def executor_for(cluster: str | None, workers: int) -> Iterator[Executor]:
    """What does the tasks: processes here, or where ``cluster`` says.

    Args:
        cluster: ``local`` for a Dask cluster of so many workers here, or the address of a Dask
            scheduler; None: no Dask.
        workers: processes; at a scheduler, those that are there count.

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


class _Worker:
    """A process that does one task after the other."""

    def __init__(self, work: Work, folder: Path) -> None:
        self.pipe, theirs = spawn.Pipe()
        self.at: Numbered | None = None
        self.ready = False
        self.process: BaseProcess = spawn.Process(
            target=_serve, args=(theirs, work, folder), daemon=True
        )
        with without_interrupts():
            self.process.start()
        theirs.close()

    def give(self, numbered: Numbered) -> None:
        self.at = numbered
        try:
            self.pipe.send(numbered)
        except OSError:  # it has died; the next to be heard of it is the end of its pipe
            return

    def end(self, *, kill: bool) -> None:
        if kill:
            self.process.terminate()
        self.pipe.close()  # it ends by itself when it hears no more
        self.process.join(_PATIENCE)
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join()


class _Crew:
    """Workers, what waits for them, and how often it was tried."""

    def __init__(self, work: Work, folder: Path, tasks: Sequence[Numbered]) -> None:
        self._work, self._folder = work, folder
        self._waiting = deque(tasks)
        self._deaths: Counter[int] = Counter()
        self._false_starts = 0
        self._cold = not compiled()
        self._workers: list[_Worker] = []

    def run(self, count: int) -> Generator[Done, None, None]:
        done = False
        try:
            self._workers = [self._hire() for _ in range(count)]
            while self._waiting or any(each.at for each in self._workers):
                heard = wait([each.pipe for each in self._workers])
                for worker in [each for each in self._workers if each.pipe in heard]:
                    yield from self._hear(worker)
                self._give()
            done = True
        finally:
            for each in self._workers:
                each.end(kill=not done)

    def _hire(self) -> _Worker:
        return _Worker(self._work, self._folder)

    def _hear(self, worker: _Worker) -> Iterator[Done]:
        try:
            said = worker.pipe.recv()
        except (EOFError, OSError):
            yield from self._bury(worker)
            return
        if said is None:
            worker.ready, self._false_starts = True, 0
            return
        worker.at, self._cold = None, False
        yield said

    def _bury(self, worker: _Worker) -> Iterator[Done]:
        worker.end(kill=False)
        self._workers.remove(worker)
        how = _end_of(worker.process.exitcode)
        if worker.at is None:
            self._false_starts += 1
            if self._false_starts >= _FALSE_STARTS:
                raise WorkersFailed(f"processes end before their first task ({how})")
        else:
            index, _ = worker.at
            self._deaths[index] += 1
            if self._deaths[index] > RETRIES:
                times = self._deaths[index]
                yield Done(index, (), Fault(f"its process died, {times} times ({how})"))
            else:
                self._waiting.appendleft(worker.at)
        if self._waiting:
            self._workers.append(self._hire())

    def _give(self) -> None:
        """Tasks to who is free; to one alone while nothing is compiled yet.

        Two processes that compile the same at the same time may spoil numba's index of it.
        """
        for worker in self._workers:
            busy = any(each.at for each in self._workers)
            if not self._waiting or (self._cold and busy):
                return
            if worker.ready and worker.at is None:
                worker.give(self._waiting.popleft())


def _serve(pipe: Connection, work: Work, folder: Path) -> None:
    """What a process does: tasks from a pipe, until it ends."""
    leave_interrupts()
    try:
        pipe.send(None)
        while True:
            index, task = pipe.recv()
            done = do(work, folder, index, task)
            try:
                pipe.send(done)
            except (TypeError, AttributeError, ValueError) as failure:  # not to be pickled
                pipe.send(Done(index, (), Fault.of(failure)))
    except (EOFError, OSError):
        return


def _end_of(code: int | None) -> str:
    if code is None or code >= 0:
        return f"exit status {code}"
    names = {int(each): each.name for each in signal.Signals}
    return f"killed by {names.get(-code, f'signal {-code}')}"
