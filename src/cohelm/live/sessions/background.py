"""Writer thread and measuring thread of the sessions, with the tasks that wait for them."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any

from cohelm.errors import StoreError

_log = logging.getLogger(__name__)


class Background:
    """Tasks in two threads; every method may be called from any thread.

    Args:
        complete: Returns True if nothing waits for the disk; then a successful task clears
            :attr:`error`.
    """

    def __init__(self, complete: Callable[[], bool]) -> None:
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="sessions")
        self._measurer = ThreadPoolExecutor(1, thread_name_prefix="measuring")
        self._pending: set[Future[Any]] = set()
        self._lock = threading.Lock()
        self._complete = complete
        self.error = ""
        """Reason why something could not be written; empty if everything is."""

    def write(self, task: Callable[[], Any]) -> Future[Any]:
        """Run a task in the writer thread, after all earlier ones."""
        return self._submit(self._writer, task)

    def measure(self, task: Callable[[], Any]) -> None:
        """Run a task in the measuring thread, after all tasks so far."""
        with self._lock:
            before = set(self._pending)

        def run() -> None:
            wait(before)
            task()

        self._submit(self._measurer, run)

    def wait(self, timeout: float) -> None:
        """Wait for the tasks so far, up to ``timeout``, s."""
        with self._lock:
            pending = set(self._pending)
        wait(pending, timeout)

    def wait_until_idle(self) -> None:
        """Wait for all tasks, and for those that they add."""
        while True:
            with self._lock:
                pending = set(self._pending)
            if not pending:
                return
            wait(pending)

    def close(self) -> None:
        """End the threads."""
        self._measurer.shutdown()
        self._writer.shutdown()

    def _submit(self, executor: ThreadPoolExecutor, task: Callable[[], Any]) -> Future[Any]:
        """Run a task; a failure is logged, and stays in ``error``."""
        future = executor.submit(self._run, task)
        with self._lock:
            self._pending.add(future)
        future.add_done_callback(self._discard)
        return future

    def _discard(self, future: Future[Any]) -> None:
        with self._lock:
            self._pending.discard(future)

    def _run(self, task: Callable[[], Any]) -> Any:
        try:
            done = task()
        except StoreError as error:
            if not self.error:  # once, not at every attempt
                _log.error("sessions: %s", error)
            self.error = error.problem
            raise
        if self._complete():
            self.error = ""
        return done
