"""Client of the navigator's process: sends requests, takes answers, replaces a failed process."""

from __future__ import annotations

import logging
from dataclasses import replace

from cohelm.live.control.ipc import ProcessReady, ProcessSetup, StepAnswer, StepRequest
from cohelm.live.control.navigator_process import serve_navigator
from cohelm.live.control.worker_process import ProcessGone, WorkerProcess

ANSWER_TIMEOUT = 10.0
"""Maximum time for an answer, s; then the process is replaced."""
LOAD_TIMEOUT = 180.0
"""The same where it first loads the code of routes, and compiles what that lacks, s."""
MAX_FAILED_STARTS = 3
"""Consecutive processes that may fail before they are ready; then no more are started."""
RESTART_DELAY = 1.0
"""Time between the loss of a process and its replacement, s."""
_log = logging.getLogger(__name__)


class NavigatorClient:
    """Navigator's process, replaced whenever it is lost.

    Args:
        setup: Argument of each process.
    """

    def __init__(self, setup: ProcessSetup) -> None:
        self._process_setup = setup
        self._process: WorkerProcess | None = None
        self._start_at = 0.0
        self._failed_starts = 0
        self.requested_at = 0.0
        """Time of the last request, s."""
        self.pending: StepRequest | None = None
        """Request without an answer so far."""
        self.unanswered: StepRequest | None = None
        """Request that the last lost process did not answer."""
        self.ready = False
        """True if it accepts requests."""
        self.routes = True
        """False: it has not loaded the code that only routes need."""
        self.lost = ""
        """Reason of the last loss; the control loop resets it to empty."""
        self.starts = 0
        """Number of processes so far."""

    @property
    def gave_up(self) -> bool:
        """True if no more processes are started."""
        return self._failed_starts >= MAX_FAILED_STARTS

    @property
    def pid(self) -> int | None:
        """Id of the current process; None: there is none."""
        return self._process.pid if self._process is not None else None

    @property
    def free(self) -> bool:
        """True if it waits for a request."""
        return self.ready and self.pending is None

    def supervise(self, now: float, *, routes: bool = True) -> bool:
        """Start a missing process and follow its progress.

        Args:
            now: s.
            routes: False: the code that only routes need is still being compiled.

        Returns:
            True in the one call that finds a new process ready.
        """
        if self._process is None:
            if now >= self._start_at and not self.gave_up:
                setup, self.routes = replace(self._process_setup, routes=routes), routes
                self._process = WorkerProcess(serve_navigator, setup, "cohelm-navigator")
                self.starts += 1
            return False
        if self.ready:
            return False
        message = self._receive(0.0, now)
        while isinstance(message, ProcessReady) and not message.done:
            _log.info("the navigator starts: %s", message.progress)
            message = self._receive(0.0, now)
        self.ready = isinstance(message, ProcessReady)
        self._failed_starts = 0 if self.ready else self._failed_starts
        return self.ready

    def request(self, request: StepRequest, now: float) -> None:
        """Send a request if the navigator is free."""
        if not self.free or self._process is None:
            return
        self.pending, self.requested_at = request, now
        try:
            self._process.send(request)
        except ProcessGone as cause:
            self._lose(now, str(cause))

    def answer(self, timeout: float, now: float) -> StepAnswer | None:
        """Return the answer to the pending request if it arrives within ``timeout``, s."""
        if self.pending is None or not self.ready:
            return None
        message = self._receive(timeout, now)
        if isinstance(message, StepAnswer):
            self.pending = None
            return message
        if self._process is None:
            return None
        limit = LOAD_TIMEOUT if self.pending.load_routes else ANSWER_TIMEOUT
        if now - self.requested_at > limit:
            self._lose(now, f"no answer for {limit:g} s")
        return None

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.close()
        self._process, self.ready, self.pending = None, False, None

    def _receive(self, timeout: float, now: float) -> object | None:
        if self._process is None:
            return None
        try:
            message: object | None = self._process.receive(timeout)
        except ProcessGone as cause:
            self._lose(now, str(cause))
            return None
        return message

    def _lose(self, now: float, reason: str) -> None:
        """End a useless process; its replacement starts after :data:`RESTART_DELAY`."""
        _log.error("the navigator is lost: %s", reason)
        self.lost = reason
        self._failed_starts += not self.ready
        if self._process is not None:
            self._process.kill()
        self.unanswered = self.pending
        self._process, self.ready, self.pending = None, False, None
        self._start_at = now + RESTART_DELAY
