"""Compilation at a first start: its process, and how far it is."""

from __future__ import annotations

import logging

from cohelm.kernel_cache import CompileProgress
from cohelm.live.control.ipc import ProcessReady
from cohelm.live.control.navigator_process import ROUTES
from cohelm.live.control.worker_process import ProcessGone, WorkerProcess
from cohelm.live.messages import Preparing

_PERIOD = 1.0
"""Time between two looks at the progress, s."""
_NICENESS = 5
_log = logging.getLogger(__name__)


class Preparation:
    """Process that compiles what rides need, and its progress.

    If it fails, all counts as compiled: the other processes compile what they miss.
    """

    def __init__(self) -> None:
        from cohelm.live.compilation import serve_compilation  # noqa: PLC0415 # at a first start only

        self._process: WorkerProcess | None = WorkerProcess(
            serve_compilation, None, "cohelm-compiler", niceness=_NICENESS, daemon=False
        )
        self._progress, self._next_look = CompileProgress(), 0.0
        self.steerable = False
        """True once a chair without a destination finds all that it needs."""
        self.state: Preparing | None = Preparing(share=0.0)
        """What pages show; None once everything is compiled."""

    @property
    def done(self) -> bool:
        """True once everything is compiled."""
        return self.state is None

    def poll(self, now: float) -> None:
        """Follow the process; ``now`` in s."""
        if self._process is None or now < self._next_look:
            return
        self._next_look = now + _PERIOD
        try:
            while isinstance(message := self._process.receive(0.0), ProcessReady):
                _log.info("compiling: %s", message.progress)
                self.steerable |= message.done or message.progress == ROUTES
                if message.done:  # it ends by itself: to wait for it would delay the loop
                    self._process = self.state = None
                    return
        except ProcessGone as cause:
            _log.error("compiling has failed: %s", cause)
            self.steerable, self._process, self.state = True, None, None
            return
        share, left = self._progress.estimate()
        self.state = Preparing(share=share, left=left)

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.close()
        self._process, self.state = None, None
