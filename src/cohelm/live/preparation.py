"""Compilation at a first start: its process, and how far it is."""

from __future__ import annotations

import logging

from cohelm.live.control.ipc import CompileStatus
from cohelm.live.control.worker_process import ProcessGone, WorkerProcess

_NICENESS = 5
_log = logging.getLogger(__name__)


class Preparation:
    """Process that compiles what rides need, and its status.

    If it fails, all counts as compiled: the other processes compile what they miss.

    Args:
        early: False: nothing is ready before all is, since a real chair shall not drive while the
            compiler has the computer.
    """

    def __init__(self, *, early: bool) -> None:
        from cohelm.live.compilation import serve_compilation  # noqa: PLC0415 # at a first start only

        self._process: WorkerProcess | None = WorkerProcess(
            serve_compilation, None, "cohelm-compiler", niceness=_NICENESS, daemon=False
        )
        self._early = early
        self.status = CompileStatus()

    @property
    def steerable(self) -> bool:
        """True once a chair without a destination may be driven."""
        return self.status.done or (self._early and self.status.steerable)

    def poll(self) -> None:
        """Take the newest status."""
        if self._process is None or self.status.done:
            return
        try:
            while isinstance(message := self._process.receive(0.0), CompileStatus):
                self.status = message
                if message.done:  # it ends by itself
                    return
        except ProcessGone as cause:
            _log.error("compiling has failed: %s", cause)  # its traceback is on stderr
            self.status = CompileStatus(share=1.0, steerable=True, done=True)

    def close(self) -> None:
        """End the process at once; what it has compiled is kept."""
        if self._process is not None:
            self._process.kill()
        self._process = None
