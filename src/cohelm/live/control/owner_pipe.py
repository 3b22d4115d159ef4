"""Worker process as seen from inside: its ride, and the pipe to its owner."""

from __future__ import annotations

import warnings
from multiprocessing.connection import Connection
from typing import Any

from cohelm.errors import CohelmError
from cohelm.live.control.ipc import ProcessSetup
from cohelm.maps import MapWarning
from cohelm.scenarios import RideSetup
from cohelm.scenarios.build import build_scenario


class OwnerGone(Exception):
    """The owner of this process has closed the pipe, or is gone."""


def build_again(setup: ProcessSetup) -> RideSetup | None:
    """Build the owner's ride in this process.

    The owner builds it too: it shows warnings and reports an error, here None.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        try:
            return build_scenario(setup.scenario, setup.seed)
        except CohelmError:
            return None


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
