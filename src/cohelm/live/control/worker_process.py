"""Handle of a process with a pipe, for the owner of the process. POSIX only.

Each call has an upper bound of its duration: ``send`` and ``receive`` :data:`PIPE_TIMEOUT` (and the
given time) for each part of a message, ``kill`` 1 s, ``close`` 2 s and that of ``kill``.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import socket
import struct
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from cohelm.processes import spawn, without_interrupts

PIPE_TIMEOUT = 0.03
"""Maximum time for the next part of a message, s; a process that takes longer is suspended."""
_KILL_TIMEOUT = 1.0
"""Maximum time for a killed process to end, s."""
_BUFFER = 1 << 20  # bytes; the operating system may allow less
Setup = TypeVar("Setup")
"""Argument of the process."""


class ProcessGone(Exception):
    """The process has ended, or its pipe is damaged."""


class WorkerProcess:
    """Process at the other end of a pipe.

    Args:
        work: Main function of the process, at the top level of a module.
        setup: Its argument.
        name: Name of the process.
        daemon: False: it may have processes of its own, and must be closed.
        niceness: Added to that of the owner, from the first instruction on: to import the program
            takes seconds of computing, also while the chair drives.
    """

    def __init__(
        self,
        work: Callable[[Connection, Setup], None],
        setup: Setup,
        name: str,
        *,
        niceness: int = 0,
        daemon: bool = True,
    ) -> None:
        self._pipe, theirs = spawn.Pipe()
        _set_timeouts(self._pipe)
        self.process: BaseProcess = spawn.Process(
            target=work, args=(theirs, setup), name=name, daemon=daemon
        )
        with without_interrupts():
            self.process.start()
        if niceness and self.process.pid is not None:
            with contextlib.suppress(OSError):  # it has ended already
                own = os.getpriority(os.PRIO_PROCESS, 0)
                os.setpriority(os.PRIO_PROCESS, self.process.pid, own + niceness)
        theirs.close()

    @property
    def pid(self) -> int | None:
        """Process id."""
        return self.process.pid

    def send(self, message: Any) -> None:
        """Send a request.

        Raises:
            ProcessGone: The process does not take it.
        """
        try:
            self._pipe.send(message)
        except (OSError, ValueError) as cause:
            raise ProcessGone(f"takes no requests ({cause})") from None

    def receive(self, timeout: float) -> Any | None:
        """Return the next answer within ``timeout``, s; None: there is none.

        Raises:
            ProcessGone: There will be no more answers.
        """
        try:
            return self._pipe.recv() if self._pipe.poll(timeout) else None
        except (OSError, EOFError, ValueError, pickle.UnpicklingError) as cause:
            raise ProcessGone(f"gives no answers ({cause!r})") from None

    def kill(self) -> None:
        """End the process at once; waits up to 1 s for its end."""
        with contextlib.suppress(OSError):
            self._pipe.close()
        if self.process.is_alive():
            self.process.kill()
        self.process.join(_KILL_TIMEOUT)

    def close(self, timeout: float = 2.0) -> None:
        """Let the process end by itself, and kill it after ``timeout``, s."""
        with contextlib.suppress(OSError):
            self._pipe.close()
        self.process.join(timeout)
        self.kill()


def _set_timeouts(pipe: Connection) -> None:
    """Let a message fail that makes no progress because the other process is suspended."""
    timeout = struct.pack("ll", 0, int(PIPE_TIMEOUT * 1e6))
    with socket.socket(fileno=os.dup(pipe.fileno())) as end:
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            end.setsockopt(socket.SOL_SOCKET, option, timeout)
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            end.setsockopt(socket.SOL_SOCKET, option, _BUFFER)
