"""Log of a live ride, written to disk tick by tick, so that memory stays constant.

It belongs to the navigator's process. Each tick is one row in a file, see :mod:`.ride_rows`, which
the operating system has at once: a killed program loses none. Memory holds the stops, the first
route and the last request. ``RideTracker`` decides when a ride begins and ends, ``measuring`` reads
the rows.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import math
import os
from pathlib import Path

import numpy as np

from cohelm.evaluation.episode.ride import StopEvent
from cohelm.evaluation.episode.ride_log import StopLog
from cohelm.health import NO_CHANGES
from cohelm.live.messages import RideOutcome
from cohelm.live.sessions.files import unwritable
from cohelm.live.sessions.records import RideLog, RideStop
from cohelm.live.sessions.ride_rows import row_of_tick
from cohelm.navigation import Tick
from cohelm.simulation import GroundTruth

MAX_STOPS = 500
"""Maximum number of stops of a ride; the longest ones are kept."""
_log = logging.getLogger(__name__)


class RideLogWriter:
    """Log of one ride after another, each between :meth:`begin` and :meth:`end`."""

    def __init__(self) -> None:
        self._ride: _Ride | None = None
        self.error = ""
        """Reason why the rows of this ride are not stored; empty if they are."""

    def begin(self, ride: str, file: Path) -> None:
        """Begin a ride with the next tick; an unfinished one keeps its rows.

        If the disk is full, the ride goes on without rows until there is space; :attr:`error`
        says so.

        Args:
            ride: Id of the ride.
            file: File for its rows; overwritten.
        """
        self._discard()
        self._ride, self.error = _Ride(ride, file), ""
        self._write(self._ride, b"")

    def add(self, tick: Tick, truth: GroundTruth) -> None:
        """Add a tick to the current ride, if there is one."""
        ride = self._ride
        if ride is None:
            return
        ride.add(tick, truth)
        self._write(ride, row_of_tick(tick, truth, ride.first_time).tobytes())

    def _write(self, ride: _Ride, row: bytes) -> None:
        """Write a row as a whole or not at all; after a failure the next one is tried again."""
        try:
            ride.write(row)
        except OSError as cause:
            ride.lost += bool(row)
            error = unwritable(ride.file, cause)
            if not self.error:  # once, not at every row
                _log.error("rows of a ride are lost: %s", error)
            self.error = error.problem
        else:
            self.error = ""

    def end(self, outcome: RideOutcome) -> RideLog | None:
        """End the ride and return its log; None without a ride or without ticks."""
        if self._ride is None or self._ride.ticks == 0:
            self._discard()
            return None
        ride, self._ride = self._ride, None
        ride.close()
        return ride.log(outcome)

    def _discard(self) -> None:
        ride, self._ride = self._ride, None
        if ride is not None:
            ride.close()
            if ride.ticks == 0:
                with contextlib.suppress(OSError):  # it is empty
                    ride.file.unlink(missing_ok=True)


class _Ride:
    """Ride in progress; its memory does not grow with every tick."""

    def __init__(self, ride: str, file: Path) -> None:
        self.id, self.file = ride, file
        self.lost = 0
        """Number of rows that could not be written."""
        self._handle: int | None = None
        self._size = 0
        """Size of the complete rows, bytes."""
        self.ticks = 0
        self.first_time = self._now = 0.0
        self._first: Tick | None = None
        self._last: Tick | None = None
        self._stops = StopLog()
        self._nearest = math.inf

    def add(self, tick: Tick, truth: GroundTruth) -> None:
        if self.ticks == 0:
            self.first_time = truth.time
        if self._first is None and tick.path is not None:
            self._first = tick
        self._last, self._now = tick, truth.time
        self._nearest = min(self._nearest, float(truth.gap_people.min(initial=math.inf)))
        self._stops.add(truth, tick)
        if len(self._stops.all) > 2 * MAX_STOPS:
            self._stops.all[:] = _longest([*self._stops.all[:-1]]) + self._stops.all[-1:]
        self.ticks += 1

    def write(self, row: bytes) -> None:
        if self._handle is None:
            flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
            self._handle = os.open(self.file, flags, 0o600)
        try:
            written = os.pwrite(self._handle, row, self._size)
        except OSError:
            written = 0
            raise
        finally:
            if written < len(row):
                os.ftruncate(self._handle, self._size)
        if written < len(row):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._size += len(row)

    def close(self) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            with contextlib.suppress(OSError):  # all rows are written
                os.close(handle)

    def log(self, outcome: RideOutcome) -> RideLog:
        request = self._last.request if self._last is not None else None
        first = (self._first or self._last).request if self._last is not None else None
        prefer = (
            [w.points for w in first.wishes if w.kind == "attract"] if first is not None else []
        )
        health = self._last.memory.health if self._last is not None else None
        return RideLog(
            ride=self.id,
            changes=NO_CHANGES if health is None else health.changes,
            file=self.file,
            outcome=outcome,
            step=(self._now - self.first_time) / max(self.ticks - 1, 1),
            goal=np.full(2, np.nan) if request is None else request.goal,
            lost_rows=self.lost,
            nearest=max(self._nearest, 0.0),
            stops=tuple(
                RideStop(
                    time=each.time - self.first_time,
                    duration=each.duration,
                    code=each.reason.value,
                    text=each.reason.sentence,
                )
                for each in _longest(self._stops.all)
            ),
            path=self._first.path if self._first is not None else None,
            prefer=np.vstack(prefer) if prefer else np.empty((0, 2)),
        )


def _longest(stops: list[StopEvent]) -> list[StopEvent]:
    """Return the longest stops, in order of time."""
    kept = sorted(stops, key=lambda stop: stop.duration, reverse=True)[:MAX_STOPS]
    return sorted(kept, key=lambda stop: stop.time)
