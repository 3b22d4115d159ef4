"""The rides of a drive: when each begins and ends, and what is kept of it."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from cohelm.driving.hearing import Tell
from cohelm.driving.limits import InForce
from cohelm.driving.messages import Device
from cohelm.driving.records import Outcome, RideLog, RideRecord
from cohelm.driving.sessions import Sessions
from cohelm.driving.trip import Trip
from cohelm.driving.wanted import Errand
from cohelm.errors import StoreError
from cohelm.evaluation import Stage
from cohelm.messages import Decision

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Marks:
    """What the navigator's process must be told of beginnings and ends."""

    end: Outcome | None = None
    begin: tuple[str, Path] | None = None


def _utc() -> datetime:
    return datetime.now(UTC)


class Outings:
    """Ride after ride: from the first movement until the chair arrives, touches, or is left.

    Who steers and then says where to go is on the same ride; who then goes elsewhere is on another.

    Args:
        sessions: keeps the rides.
        in_force: limits.
        tell: of ends.
        step: of the chair, s.
        wall: what time it is.
    """

    def __init__(
        self,
        sessions: Sessions,
        in_force: InForce,
        tell: Tell,
        step: float,
        wall: Callable[[], datetime] = _utc,
    ) -> None:
        self._sessions, self._in_force, self._tell = sessions, in_force, tell
        self._step, self._wall = step, wall
        self._session = ""
        self._trip: Trip | None = None
        self._stage: Stage | None = None
        self._ended: dict[str, tuple[Trip, Outcome, Stage]] = {}
        self._ratings: dict[str, int] = {}
        self._marks = Marks()
        self._fails = False

    @property
    def ride(self) -> str:
        """The id of the ride that goes on; empty: none."""
        return self._trip.ride if self._trip is not None else ""

    @property
    def owing(self) -> bool:
        """Whether the navigator's process has yet to hand over the log of a ride that ended."""
        return bool(self._ended)

    def on(self, stage: Stage) -> None:
        """What is driven in from now on."""
        self.end("left")
        self._stage = stage
        if not self._session:
            with contextlib.suppress(StoreError):  # said when a ride begins
                self._session = self._sessions.begin(stage).id

    def marks(self) -> Marks:
        """What is to be told with the next question; told once."""
        marks, self._marks = self._marks, Marks()
        return marks

    def went(self, order: Decision, errand: Errand, *, way: float, device: Device) -> None:
        """A step was driven.

        Args:
            order: what was at the wheels.
            errand: what was wanted.
            way: how far the chair came, m.
            device: what steered.
        """
        if self._trip is not None and self._trip.goal not in {None, errand.goal}:
            self.end("left")  # it goes elsewhere now
        self._fails &= bool(order.twist.any())
        if self._trip is None and order.twist.any() and not self._fails:
            self._begin()
        if self._trip is not None:
            limits, wishes = self._in_force.limits, len(errand.wishes)
            trip = replace(self._trip, goal=errand.goal)
            self._trip = trip.on(self._step, way, errand.drives, device, limits, wishes)

    def end(self, outcome: Outcome) -> None:
        """The ride is over, where there is one."""
        trip, self._trip = self._trip, None
        if trip is None or self._stage is None:
            return
        self._tell(trip.ended(outcome), None)
        self._ended[trip.ride] = trip, outcome, self._stage
        self._marks = Marks(end=outcome)

    def logged(self, log: RideLog | None) -> None:
        """The navigator's process handed over the log of a ride that ended."""
        if log is None or log.ride not in self._ended:
            return
        trip, outcome, stage = self._ended.pop(log.ride)
        self._keep(trip.record(outcome, log), log, stage)

    def lost(self) -> None:
        """The navigator's process is gone, and with it what it had not handed over."""
        self.end("left")
        for trip, outcome, stage in self._ended.values():
            self._keep(trip.record(outcome, None), None, stage)
        self._ended.clear()
        self._marks = Marks()

    def rate(self, ride: str, rating: int) -> None:
        """How a ride was; of one whose log is still to come it is kept with the log.

        Raises:
            StoreError: if there is no such ride.
        """
        if ride in self._ended:
            self._ratings[ride] = rating
        else:
            self._sessions.rate(ride, rating)

    def _keep(self, record: RideRecord, log: RideLog | None, stage: Stage) -> None:
        self._sessions.keep(record, log, stage)
        rating = self._ratings.pop(record.id, None)
        if rating is not None:
            with contextlib.suppress(StoreError):  # its session was deleted meanwhile
                self._sessions.rate(record.id, rating)

    def _begin(self) -> None:
        if self._stage is None:
            return
        try:
            self._session = self._session or self._sessions.begin(self._stage).id
            ride, file = self._sessions.begin_ride()
        except StoreError as trouble:
            _log.error("a ride is not kept: %s", trouble)
            self._fails = True  # until the chair sets off again
            return
        self._trip = Trip(
            ride=ride,
            session=self._session,
            began=self._wall().isoformat(timespec="seconds"),
            seed=self._stage.seed,
        )
        self._marks = Marks(end=self._marks.end, begin=(ride, file))
