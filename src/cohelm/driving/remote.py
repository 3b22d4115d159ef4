"""A process that thinks, as whoever asks it sees it: nothing here ever waits for it for long."""

from __future__ import annotations

import contextlib
import os
import pickle
import socket
import struct
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from cohelm.driving.asking import Charge
from cohelm.evaluation.processes import spawn, without_interrupts

STUCK = 0.03
"""A message that goes no further for longer was to or from a process that stands still, s."""
_BUFFER = 1 << 20  # bytes; as much as the operating system allows


class Gone(Exception):
    """The process has ended, or its pipe is damaged: it is of no more use."""


class Remote:
    """A process at the other end of a pipe.

    Args:
        work: what it does; a function at the top level of a module.
        charge: what it is made with.
        name: of the process.
    """

    def __init__(
        self, work: Callable[[Connection, Charge], None], charge: Charge, name: str
    ) -> None:
        self._pipe, theirs = spawn.Pipe()
        _hurry(self._pipe)
        self.process: BaseProcess = spawn.Process(
            target=work, args=(theirs, charge), name=name, daemon=True
        )
        with without_interrupts():
            self.process.start()
        theirs.close()

    @property
    def pid(self) -> int | None:
        """Of the process."""
        return self.process.pid

    def send(self, message: Any) -> None:
        """Put a question into the pipe.

        Raises:
            Gone: if nobody takes it.
        """
        try:
            self._pipe.send(message)
        except (OSError, ValueError) as cause:
            raise Gone(f"takes no questions ({cause})") from None

    def receive(self, timeout: float) -> Any | None:
        """What it says within ``timeout``, s; None: nothing.

        Raises:
            Gone: if it will never say anything any more.
        """
        try:
            return self._pipe.recv() if self._pipe.poll(timeout) else None
        except (OSError, EOFError, ValueError, pickle.UnpicklingError) as cause:
            raise Gone(f"gives no answers ({cause!r})") from None

    def kill(self) -> None:
        """End it at once, however it is."""
        with contextlib.suppress(OSError):
            self._pipe.close()
        if self.process.is_alive():
            self.process.kill()
        self.process.join(1.0)

    def close(self, patience: float = 2.0) -> None:
        """Let it end by itself, and end it where it does not."""
        with contextlib.suppress(OSError):
            self._pipe.close()
        self.process.join(patience)
        self.kill()


def _hurry(pipe: Connection) -> None:
    """Give up on a message that gets stuck half way: the other end has been stopped."""
    wait = struct.pack("ll", 0, int(STUCK * 1e6))
    with socket.socket(fileno=os.dup(pipe.fileno())) as end:
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            end.setsockopt(socket.SOL_SOCKET, option, wait)
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            end.setsockopt(socket.SOL_SOCKET, option, _BUFFER)
