"""What is kept of sessions: in one folder of this machine, and gone by one action.

    DIR/                       0700
      settings.json            limits and the rider's settings, see ``limits``
      audit.jsonl              see ``audit``; deleting sessions leaves it
      20260131-142530/         a session
        session.json
        20260131-142530-r1.json   a ride's record; .png its map; .rows its log until it is measured

Every method may be called from any thread. Writing is done aside, in the order asked for, so that
nobody who drives waits for a disk; what goes wrong there stands in :attr:`Sessions.trouble`.
"""

from __future__ import annotations

from pathlib import Path

from cohelm.driving.records import RideRecord, SessionFacts, SessionSummary
from cohelm.evaluation import Stage


class Sessions:
    """The store.

    Args:
        folder: where; made where it is missing.

    Raises:
        StoreError: if it cannot be made or written to.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def begin(self, stage: Stage, *, simulation: bool = True) -> SessionFacts:
        """A session of its own for what is now driven; every further ride belongs to it."""
        raise NotImplementedError

    def begin_ride(self) -> tuple[str, Path]:
        """The next ride's id, and the file in which the navigator's process keeps its rows."""
        raise NotImplementedError

    def keep(self, record: RideRecord, log: object | None, stage: Stage) -> None:
        """Keep a ride that has ended; its measures and its map are made aside from ``log``."""
        raise NotImplementedError

    def rate(self, ride: str, rating: int) -> None:
        """How a ride was, 1 to 5; another time overwrites.

        Raises:
            StoreError: if there is no such ride.
        """
        raise NotImplementedError

    def list(self) -> tuple[SessionSummary, ...]:
        """All sessions that have a ride, the newest first."""
        raise NotImplementedError

    def summary(self, session: str) -> SessionSummary:
        """One session.

        Raises:
            StoreError: if there is none of this id.
        """
        raise NotImplementedError

    def html(self, session: str) -> str:
        """The session as a page that needs nothing else and can be printed; see ``summary``."""
        raise NotImplementedError

    def csv(self, session: str) -> str:
        """A row for each ride; see ``summary``."""
        raise NotImplementedError

    def png(self, id_: str) -> bytes:
        """The map of a ride, or of a session's last one; see ``summary``."""
        raise NotImplementedError

    def delete_all(self) -> int:
        """Delete every session there is, the one going on too; how many they were.

        A ride that is going on is not kept. The audit log and the settings stay.

        Raises:
            StoreError: if something could not be deleted; names it.
        """
        raise NotImplementedError

    def settle(self) -> None:
        """Wait until all that was to be written is."""
        raise NotImplementedError

    def close(self) -> None:
        """Settle, and write nothing more."""
        raise NotImplementedError

    @property
    def trouble(self) -> str:
        """What could not be written last, in words; empty: nothing."""
        raise NotImplementedError
