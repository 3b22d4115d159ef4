"""Pipe to the owner of a process, as seen from inside that process."""

from __future__ import annotations

from multiprocessing.connection import Connection
from typing import Any


class OwnerGone(Exception):
    """The owner of this process has closed the pipe, or is gone."""


class OwnerPipe:
    """End of the pipe in a worker process.

    Args:
        pipe: Connection that the process was started with.
    """

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe

    def send(self, message: Any) -> None:
        """Send an answer.

        Raises:
            OwnerGone: Nobody can receive it.
        """
        try:
            self._pipe.send(message)
        except OSError as cause:
            raise OwnerGone from cause

    def receive(self) -> Any:
        """Wait for the next request and return it.

        Raises:
            OwnerGone: There will be no more requests.
        """
        try:
            return self._pipe.recv()
        except (EOFError, OSError) as cause:
            raise OwnerGone from cause
