"""The log of a ride that a person drives: kept on disk as it grows, so that memory stays flat.

It lives in the navigator's process. Each tick is one row of numbers in a file of the ride; what is
kept in memory are counts, the stops and the first route.
"""

from __future__ import annotations

from pathlib import Path

from cohelm.driving.records import Outcome, RideLog
from cohelm.navigation import Tick
from cohelm.simulation import Truth


class Logbook:
    """Ride after ride; each between :meth:`begin` and :meth:`end`."""

    def begin(self, ride: str, file: Path) -> None:
        """From the next tick on it is this ride; one that was going on is thrown away.

        Args:
            ride: its id.
            file: for its rows, see :meth:`.sessions.Sessions.rows_file`; written over.
        """
        raise NotImplementedError

    def add(self, tick: Tick, truth: Truth) -> Outcome | None:
        """One more tick; no ride: nothing happens.

        Returns:
            how the ride has just ended by itself: within 0.2 m of the goal and standing, or by a
            new contact of the moving chair; None: it goes on.
        """
        raise NotImplementedError

    def end(self, outcome: Outcome) -> RideLog | None:
        """Close the ride; None where there is none, or it had no tick."""
        raise NotImplementedError
