"""Executors of tasks: in this process, or in worker processes.

A worker process that dies is replaced, and its task is tried again, at most twice; the exit status
or signal is kept, which is why this is not a ``concurrent.futures`` pool. An exception in a task is
returned as its error.
"""

from __future__ import annotations

import signal
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Sequence
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from cohelm import kernel_cache
from cohelm.errors import CohelmError
from cohelm.evaluation.sweeps.tasks import CompletedTask, Task, TaskError, Work
from cohelm.processes import leave_interrupts, spawn, without_interrupts

Numbered = tuple[int, Task]
Executor = Callable[[Work, Path, Sequence[Numbered]], Generator[CompletedTask, None, None]]
"""Does tasks, each with its index, and yields them in the order of completion."""

RETRIES = 2
"""Number of further tries of a task whose process died."""
_FALSE_STARTS = 3
_PATIENCE = 5.0  # s, for a process to end


class WorkersFailed(CohelmError):
    """Workers do not start, or have other versions than the sweep needs."""

    code = "workers"


def do(work: Work, folder: Path, index: int, task: Task) -> CompletedTask:
    """Do one task; an exception becomes its error."""
    try:
        return CompletedTask(index, tuple(work(task, folder)))
    except (Exception, SystemExit) as failure:  # the other tasks go on
        return CompletedTask(index, (), TaskError.of(failure))


def serially(
    work: Work, folder: Path, tasks: Sequence[Numbered]
) -> Generator[CompletedTask, None, None]:
    """Do the tasks in this process, one after the other."""
    for index, task in tasks:
        yield do(work, folder, index, task)


def in_processes(workers: int) -> Executor:
    """Executor with a number of worker processes; with one it uses this process."""

    def run(
        work: Work, folder: Path, tasks: Sequence[Numbered]
    ) -> Generator[CompletedTask, None, None]:
        count = min(workers, len(tasks))
        if count <= 1:
            return serially(work, folder, tasks)
        return _Pool(work, folder, tasks).run(count)

    return run


class _Worker:
    """Worker process that does one task after the other."""

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
        except OSError:  # it has died; its pipe will report the end
            return

    def end(self, *, kill: bool) -> None:
        if kill:
            self.process.terminate()
        self.pipe.close()  # the process ends at the end of its pipe
        self.process.join(_PATIENCE)
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join()


class _Pool:
    """Worker processes, waiting tasks, and the number of their tries."""

    def __init__(self, work: Work, folder: Path, tasks: Sequence[Numbered]) -> None:
        self._work, self._folder = work, folder
        self._waiting = deque(tasks)
        self._deaths: Counter[int] = Counter()
        self._false_starts = 0
        self._cold = not kernel_cache.is_filled()
        self._workers: list[_Worker] = []

    def run(self, count: int) -> Generator[CompletedTask, None, None]:
        done = False
        try:
            self._workers = [_Worker(self._work, self._folder) for _ in range(count)]
            while self._waiting or any(each.at for each in self._workers):
                ready = wait([each.pipe for each in self._workers])
                for worker in [each for each in self._workers if each.pipe in ready]:
                    yield from self._receive(worker)
                self._give()
            done = True
        finally:
            for each in self._workers:
                each.end(kill=not done)

    def _receive(self, worker: _Worker) -> Iterator[CompletedTask]:
        try:
            message = worker.pipe.recv()
        except (EOFError, OSError):
            yield from self._replace(worker)
            return
        if message is None:
            worker.ready, self._false_starts = True, 0
            return
        worker.at, self._cold = None, False
        yield message

    def _replace(self, worker: _Worker) -> Iterator[CompletedTask]:
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
                error = TaskError(f"its process died, {times} times ({how})")
                yield CompletedTask(index, (), error)
            else:
                self._waiting.appendleft(worker.at)
        if self._waiting:
            self._workers.append(_Worker(self._work, self._folder))

    def _give(self) -> None:
        """Give tasks to free workers; to a single one while nothing is compiled yet.

        Two processes that compile the same function at once may damage numba's cache index.
        """
        for worker in self._workers:
            busy = any(each.at for each in self._workers)
            if not self._waiting or (self._cold and busy):
                return
            if worker.ready and worker.at is None:
                worker.give(self._waiting.popleft())


def _serve(pipe: Connection, work: Work, folder: Path) -> None:
    """Do tasks from a pipe until it ends."""
    leave_interrupts()
    try:
        pipe.send(None)
        while True:
            index, task = pipe.recv()
            done = do(work, folder, index, task)
            try:
                pipe.send(done)
            except (TypeError, AttributeError, ValueError) as failure:  # cannot be pickled
                pipe.send(CompletedTask(index, (), TaskError.of(failure)))
    except (EOFError, OSError):
        return


def _end_of(code: int | None) -> str:
    if code is None or code >= 0:
        return f"exit status {code}"
    names = {int(each): each.name for each in signal.Signals}
    return f"killed by {names.get(-code, f'signal {-code}')}"
