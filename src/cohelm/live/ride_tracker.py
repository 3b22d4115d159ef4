"""Rides of a drive: their beginnings, ends and summaries."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeVar

from cohelm.errors import StoreError
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.mission import Mission
from cohelm.live.messages import Destination, Device, RideEnded, RideOutcome, Send
from cohelm.live.sessions.records import (
    LimitsAt,
    RideBegin,
    RideLog,
    RideSummary,
    now_utc,
    session_of,
)
from cohelm.live.sessions.store import SessionStore
from cohelm.messages import Decision, Mode
from cohelm.planning.alternatives.learned_preference import RouteChoice
from cohelm.scenarios import RideSetup

_K = TypeVar("_K")
SUMMARY_PERIOD = 1.0
"""Time between two summaries in the log of a ride that goes on, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RideMarks:
    """End and beginning of rides, in this order, for one request to the navigator's process."""

    end: str = ""
    """Final summary of the ride that has begun before, JSON; empty: it goes on."""
    begin: RideBegin | None = None
    summary: str = ""
    """Summary so far of the ride that goes on, JSON; empty: not now."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveRide:
    """Ride in progress."""

    id: str
    started: str
    """ISO 8601, UTC."""
    seed: int
    time: float = 0.0
    """Duration so far, s."""
    length: float = 0.0
    """Distance driven so far, m."""
    goal: Destination | None = None
    """None: no destination, the rider steers."""
    wishes: int = 0
    """Number of active wishes."""
    choice: RouteChoice | None = None
    """Choice of the route."""
    modes: Mapping[Mode, float] = field(default_factory=dict)
    """Duration of each mode, s."""
    devices: Mapping[str, float] = field(default_factory=dict)
    """Duration of each input device, s."""
    limits: tuple[LimitsAt, ...] = ()
    """Limits in force, in order of time."""

    def after(
        self, dt: float, length: float, mission: Mission, device: Device, limits: LimitsAt
    ) -> LiveRide:
        """Return the ride after one more step.

        Args:
            dt: Length of the step, s.
            length: Distance driven in it, m.
            mission, device, limits: Those of the step.
        """
        unchanged = self.limits and self.limits[-1].limits == limits.limits
        return replace(
            self,
            time=self.time + dt,
            length=self.length + length,
            goal=mission.goal,
            wishes=len(mission.wishes),
            choice=mission.choice,
            modes=_longer(self.modes, mission.active_mode, dt),
            devices=self.devices if device == "none" else _longer(self.devices, device, dt),
            limits=self.limits if unchanged else (*self.limits, limits),
        )

    def ended(self, outcome: RideOutcome) -> RideEnded:
        """Return the message about its end."""
        return RideEnded(
            ride=self.id,
            outcome=outcome,
            duration=round(self.time, 2),
            length=round(self.length, 2),
        )

    def summary(self, outcome: RideOutcome) -> RideSummary:
        """Return the record to store."""
        return RideSummary(
            id=self.id,
            session=session_of(self.id),
            started=self.started,
            seed=self.seed,
            destination=_name(self.goal),
            outcome=outcome,
            duration=round(self.time, 2),
            length=round(self.length, 2),
            modes=self.modes,
            devices=self.devices,
            wishes=self.wishes,
            choice=self.choice,
            limits=self.limits,
        )


class _EndedRide(NamedTuple):
    """Ride that waits for its log."""

    ride: LiveRide
    outcome: RideOutcome
    ride_setup: RideSetup


class RideTracker:
    """Divides a drive into rides: from the first movement to arrival, contact or cancellation.

    A destination chosen while the rider steers continues the ride; another destination ends it.
    Belongs to the control thread.

    Args:
        store: Stores the rides.
        settings: Limits in force.
        send: Sends messages about ends.
    """

    def __init__(
        self,
        store: SessionStore,
        settings: ActiveSettings,
        send: Send,
    ) -> None:
        self._store, self._settings, self._send = store, settings, send
        self._session_rider: str | None = None
        """Rider of the current session; None: none has begun."""
        self._ride: LiveRide | None = None
        self._ride_setup: RideSetup | None = None
        self._ended: dict[str, _EndedRide] = {}
        """Rides without their logs so far, by id."""
        self._ratings: dict[str, int] = {}
        """Ratings of these rides, by id."""
        self._marks: deque[RideMarks] = deque()
        """Marks that no request has taken yet, the oldest first."""
        self._summarised_at = 0.0
        """Duration of the ride at the last summary in its log, s."""

    @property
    def ride(self) -> str:
        """Id of the current ride; empty: none."""
        return self._ride.id if self._ride is not None else ""

    @property
    def waits_for_log(self) -> bool:
        """True while the navigator's process owes the log of an ended ride."""
        return bool(self._ended)

    @property
    def error(self) -> str:
        """Reason why rides are not stored; empty if they are."""
        return self._store.error

    def retry(self) -> None:
        """Store again what could not be stored, without waiting for it."""
        if self._store.error or self._settings.error:
            self._store.retry(self._settings.retry)

    def enter(self, ride_setup: RideSetup) -> None:
        """End the current ride; further rides take place in this world."""
        self.end("cancelled")
        self._ride_setup = ride_setup

    def take_marks(self) -> RideMarks:
        """Return the marks for the next request to the navigator, each only once."""
        marks, ride = self._marks.popleft() if self._marks else RideMarks(), self._ride
        if self._marks or ride is None or ride.time - self._summarised_at < SUMMARY_PERIOD:
            return marks
        self._summarised_at = ride.time
        return replace(marks, summary=ride.summary("cancelled").model_dump_json())

    def step(
        self,
        command: Decision,
        mission: Mission,
        *,
        elapsed: float,
        length: float,
        device: Device,
    ) -> None:
        """Account for one control step.

        Args:
            command: Decision at the wheels.
            mission: Mission of the step.
            elapsed: Time since the previous step, s.
            length: Distance that the chair moved, m.
            device: Input device in use.
        """
        if self._ride is not None and self._ride.goal not in {None, mission.goal}:
            self.end("cancelled")  # it has another destination now
        if self._ride is None and command.twist.any():
            self._begin()
        if self._ride is not None:
            limits = LimitsAt(time=self._ride.time, limits=self._settings.limits)
            self._ride = self._ride.after(elapsed, length, mission, device, limits)

    def end(self, outcome: RideOutcome) -> None:
        """End the current ride, if there is one."""
        ride, self._ride = self._ride, None
        if ride is None or self._ride_setup is None:
            return
        self._send(ride.ended(outcome), None)
        self._ended[ride.id] = _EndedRide(ride, outcome, self._ride_setup)
        self._marks.append(RideMarks(end=ride.summary(outcome).model_dump_json()))

    def add_log(self, log: RideLog | None) -> None:
        """Store an ended ride with the log that the navigator's process delivered."""
        if log is None or log.ride not in self._ended:
            return
        self._keep(self._ended.pop(log.ride), log)

    def navigator_lost(self) -> None:
        """Store all ended rides without the logs that were lost with the navigator's process."""
        self.end("cancelled")
        for ended in self._ended.values():
            self._keep(ended, None)
        self._ended.clear()
        self._marks.clear()

    def rate(self, ride: str, rating: int) -> None:
        """Store a rating; while the ride's log is missing, it waits for it.

        Raises:
            StoreError: There is no such ride.
        """
        if ride in self._ended:
            self._ratings[ride] = rating
        else:
            self._store.rate(ride, rating)

    def _keep(self, ended: _EndedRide, log: RideLog | None) -> None:
        ride, outcome, ride_setup = ended
        self._store.keep(ride.summary(outcome), log, ride_setup)
        rating = self._ratings.pop(ride.id, None)
        if rating is not None:
            with contextlib.suppress(StoreError):  # its session was deleted meanwhile
                self._store.rate(ride.id, rating)

    def _begin(self) -> None:
        if self._ride_setup is None:
            return
        if self._session_rider != self._settings.person:
            self._session_rider = self._settings.person
            self._store.begin(self._ride_setup, self._session_rider)
        ride, session, file = self._store.begin_ride()
        self._ride = LiveRide(id=ride, started=now_utc(), seed=self._ride_setup.seed)
        self._summarised_at = 0.0
        summary = self._ride.summary("cancelled").model_dump_json()
        # One request can carry an end and the beginning after it, but not the other order.
        end = ""
        if self._marks and self._marks[-1].begin is None:
            end = self._marks.pop().end
        begin = RideBegin(ride, file, session.model_dump_json(), summary)
        self._marks.append(RideMarks(end=end, begin=begin))


def _name(goal: Destination | None) -> str:
    if goal is None:
        return ""
    return goal.name or f"({goal.x:.1f}, {goal.y:.1f})"


def _longer(durations: Mapping[_K, float], key: _K, dt: float) -> dict[_K, float]:
    return {**durations, key: round(durations.get(key, 0.0) + dt, 6)}
