"""The log of a ride that a person drives: kept on disk as it grows, so that memory stays flat.

It lives in the navigator's process. Each tick is one row of numbers in a file of the ride; what is
kept in memory are the stops, the first route and the last request. When a ride begins and ends, and
how far and how long it went, ``outings`` says. See ``measuring`` for what comes of it.
"""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import BinaryIO

import numpy as np

from cohelm.arrays import Floats32
from cohelm.driving.files import unwritable
from cohelm.driving.records import Outcome, RideLog, StopNote
from cohelm.evaluation.noting import Stops, row_of, states_of
from cohelm.evaluation.ride import Stop
from cohelm.navigation import Tick
from cohelm.simulation import Truth

OWN = 18
"""Numbers of a row about the chair: t, pose 3, twist 3, gap to walls, whether one was touched,
command 3, asked 3, stick 2, η. Before them stands how many people there are …"""
EACH = 10
"""… and behind them for each: gap, touched moving, touched standing, x, y, v_x, v_y, heading,
way-point, radius."""
MOST_STOPS = 500
"""Kept of a ride, the longest ones."""
_log = logging.getLogger(__name__)


class Logbook:
    """Ride after ride; each between :meth:`begin` and :meth:`end`."""

    def __init__(self) -> None:
        self._ride: _Ride | None = None

    def begin(self, ride: str, file: Path) -> None:
        """From the next tick on it is this ride; one that was going on is thrown away.

        A disk that takes nothing ends no ride: its rows are given up, and logging says so.

        Args:
            ride: its id.
            file: for its rows; written over.
        """
        self._drop()
        try:
            handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        except OSError as cause:
            _given_up(file, cause)
            self._ride = _Ride(ride, file, None)
        else:
            self._ride = _Ride(ride, file, os.fdopen(handle, "wb"))

    def add(self, tick: Tick, truth: Truth) -> None:
        """One more tick; outside of a ride nothing happens."""
        ride = self._ride
        if ride is None:
            return
        ride.note(tick, truth)
        if ride.rows is not None:
            try:
                ride.rows.write(_row(tick, truth, ride.first_time).tobytes())
            except OSError as cause:
                _given_up(ride.file, cause)
                ride.rows = None

    def end(self, outcome: Outcome) -> RideLog | None:
        """Close the ride; None where there is none, or it had no tick."""
        if self._ride is None or self._ride.ticks == 0:
            self._drop()
            return None
        ride, self._ride = self._ride, None
        ride.close()
        return ride.log(outcome)

    def _drop(self) -> None:
        ride, self._ride = self._ride, None
        if ride is not None:
            ride.close()
            ride.file.unlink(missing_ok=True)


class _Ride:
    """What is known of a ride that goes on; it does not grow with every tick."""

    def __init__(self, ride: str, file: Path, rows: BinaryIO | None) -> None:
        self.id, self.file, self.rows = ride, file, rows
        self.ticks = 0
        self.first_time = self._now = 0.0
        self._first: Tick | None = None
        self._last: Tick | None = None
        self._stops = Stops()

    def note(self, tick: Tick, truth: Truth) -> None:
        if self.ticks == 0:
            self.first_time = truth.time
        if self._first is None and tick.path is not None:
            self._first = tick
        self._last, self._now = tick, truth.time
        self._stops.add(truth, tick)
        if len(self._stops.all) > 2 * MOST_STOPS:
            self._stops.all[:] = _longest([*self._stops.all[:-1]]) + self._stops.all[-1:]
        self.ticks += 1

    def close(self) -> None:
        if self.rows is not None:
            try:
                self.rows.close()
            except OSError as cause:
                _given_up(self.file, cause)

    def log(self, outcome: Outcome) -> RideLog:
        request = self._last.request if self._last is not None else None
        asked = (self._first or self._last).request if self._last is not None else None
        prefer = [w.points for w in asked.wishes if w.kind == "attract"] if asked else []
        return RideLog(
            ride=self.id,
            file=self.file,
            outcome=outcome,
            step=(self._now - self.first_time) / max(self.ticks - 1, 1),
            goal=np.full(2, np.nan) if request is None else request.goal,
            stops=tuple(
                StopNote(
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


def _given_up(file: Path, cause: OSError) -> None:
    _log.error("rows of a ride are not kept: %s", unwritable(file, cause))


def _longest(stops: list[Stop]) -> list[Stop]:
    """The longest ones, in the order of time."""
    kept = sorted(stops, key=lambda stop: stop.duration, reverse=True)[:MOST_STOPS]
    return sorted(kept, key=lambda stop: stop.time)


def _row(tick: Tick, truth: Truth, begun: float) -> Floats32:
    """(1 + OWN + n · EACH,) numbers of a tick; see :data:`OWN`."""
    crowd = truth.crowd
    n = len(crowd.radius)
    out = np.empty(1 + OWN + n * EACH, dtype=np.float32)
    out[0] = n
    out[1] = truth.time - begun
    out[2:5], out[5:8] = truth.pose, truth.twist
    out[8], out[9] = truth.gap_wall, truth.hit_wall
    out[10 : 1 + OWN] = row_of(tick)
    people = out[1 + OWN :].reshape(n, EACH)
    people[:, 0] = truth.gap_people
    people[:, 1], people[:, 2] = truth.hit_moving, truth.hit_standing
    people[:, 3:7] = states_of(crowd)
    people[:, 7], people[:, 8], people[:, 9] = crowd.heading, crowd.target, crowd.radius
    return out
