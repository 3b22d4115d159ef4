"""Rides of a live drive: their beginnings, ends and summaries."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

from cohelm.errors import StoreError
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.mission import Mission
from cohelm.live.messages import Destination, Device, RideEnded, RideOutcome
from cohelm.live.page.commands import Send
from cohelm.live.sessions.records import LimitsAt, RideLog, RideSummary
from cohelm.live.sessions.store import SessionStore
from cohelm.messages import Decision, Mode
from cohelm.scenarios import RideSetup

_log = logging.getLogger(__name__)
_K = TypeVar("_K")


@dataclass(frozen=True, slots=True, kw_only=True)
class RideMarks:
    """Beginning and end of rides, as the navigator's process has to know them."""

    end: RideOutcome | None = None
    begin: tuple[str, Path] | None = None
    """Id of the ride, and the file for its rows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveRide:
    """Ride in progress."""

    id: str
    session: str
    started: str
    """ISO 8601, UTC."""
    seed: int
    time: float = 0.0
    """Duration so far, s."""
    length: float = 0.0
    """m."""
    goal: Destination | None = None
    """None: no destination, the rider steers."""
    wishes: int = 0
    modes: Mapping[Mode, float] = field(default_factory=dict)
    """Duration of each mode, s."""
    devices: Mapping[str, float] = field(default_factory=dict)
    """Duration of each input device, s."""
    limits: tuple[LimitsAt, ...] = ()

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

    def summary(self, outcome: RideOutcome, log: RideLog | None) -> RideSummary:
        """Return the record to store.

        Args:
            outcome: Outcome of the ride.
            log: Log by the navigator's process; None: that process was lost.
        """
        return RideSummary(
            id=self.id,
            session=self.session,
            started=self.started,
            seed=self.seed,
            destination=_name(self.goal),
            outcome=outcome,
            duration=round(self.time, 2),
            length=round(self.length, 2),
            modes=self.modes,
            devices=self.devices,
            wishes=self.wishes,
            limits=self.limits,
            stops=log.stops if log is not None else (),
        )


def _utc() -> datetime:
    return datetime.now(UTC)


class RideSessions:
    """Divides a drive into rides: from the first movement to arrival, contact or cancellation.

    A destination chosen while the rider steers continues the ride; another destination ends it.

    Args:
        sessions: Stores the rides.
        settings: Limits in force.
        send: Sends messages about ends.
        step: Control period, s.
        wall_clock: Returns the date and time.
    """

    def __init__(
        self,
        sessions: SessionStore,
        settings: ActiveSettings,
        send: Send,
        step: float,
        wall_clock: Callable[[], datetime] = _utc,
    ) -> None:
        self._sessions, self._settings, self._send = sessions, settings, send
        self._step, self._wall_clock = step, wall_clock
        self._session = ""
        self._ride: LiveRide | None = None
        self._ride_setup: RideSetup | None = None
        self._ended: dict[str, tuple[LiveRide, RideOutcome, RideSetup]] = {}
        self._ratings: dict[str, int] = {}
        self._marks = RideMarks()
        self._store_fails = False

    @property
    def ride(self) -> str:
        """Id of the present ride; empty: none."""
        return self._ride.id if self._ride is not None else ""

    @property
    def waits_for_log(self) -> bool:
        """True while the navigator's process owes the log of an ended ride."""
        return bool(self._ended)

    def enter(self, ride_setup: RideSetup) -> None:
        """End the present ride; further rides take place in this world."""
        self.end("cancelled")
        self._ride_setup = ride_setup
        if not self._session:
            with contextlib.suppress(StoreError):  # reported when a ride begins
                self._session = self._sessions.begin(ride_setup).id

    def take_marks(self) -> RideMarks:
        """Return the marks for the next request to the navigator, once."""
        marks, self._marks = self._marks, RideMarks()
        return marks

    def step(self, order: Decision, mission: Mission, *, length: float, device: Device) -> None:
        """Account for one control step.

        Args:
            order: Decision at the wheels.
            mission: Mission of the step.
            length: Distance that the chair moved, m.
            device: Input device in use.
        """
        if self._ride is not None and self._ride.goal not in {None, mission.goal}:
            self.end("cancelled")  # it has another destination now
        self._store_fails &= bool(order.twist.any())
        if self._ride is None and order.twist.any() and not self._store_fails:
            self._begin()
        if self._ride is not None:
            limits = LimitsAt(time=self._ride.time, limits=self._settings.limits)
            self._ride = self._ride.after(self._step, length, mission, device, limits)

    def end(self, outcome: RideOutcome) -> None:
        """End the present ride, if there is one."""
        ride, self._ride = self._ride, None
        if ride is None or self._ride_setup is None:
            return
        self._send(ride.ended(outcome), None)
        self._ended[ride.id] = ride, outcome, self._ride_setup
        self._marks = RideMarks(end=outcome)

    def add_log(self, log: RideLog | None) -> None:
        """Store an ended ride with the log that the navigator's process delivered."""
        if log is None or log.ride not in self._ended:
            return
        ride, outcome, ride_setup = self._ended.pop(log.ride)
        self._store(ride.summary(outcome, log), log, ride_setup)

    def navigator_lost(self) -> None:
        """Store all ended rides without the logs that were lost with the navigator's process."""
        self.end("cancelled")
        for ride, outcome, ride_setup in self._ended.values():
            self._store(ride.summary(outcome, None), None, ride_setup)
        self._ended.clear()
        self._marks = RideMarks()

    def rate(self, ride: str, rating: int) -> None:
        """Store a rating; while the ride's log is missing, it waits for it.

        Raises:
            StoreError: There is no such ride.
        """
        if ride in self._ended:
            self._ratings[ride] = rating
        else:
            self._sessions.rate(ride, rating)

    def _store(self, ride: RideSummary, log: RideLog | None, ride_setup: RideSetup) -> None:
        self._sessions.keep(ride, log, ride_setup)
        rating = self._ratings.pop(ride.id, None)
        if rating is not None:
            with contextlib.suppress(StoreError):  # its session was deleted meanwhile
                self._sessions.rate(ride.id, rating)

    def _begin(self) -> None:
        if self._ride_setup is None:
            return
        try:
            self._session = self._session or self._sessions.begin(self._ride_setup).id
            ride, file = self._sessions.begin_ride()
        except StoreError as error:
            _log.error("a ride is not stored: %s", error)
            self._store_fails = True  # until the chair starts again
            return
        self._ride = LiveRide(
            id=ride,
            session=self._session,
            started=self._wall_clock().isoformat(timespec="seconds"),
            seed=self._ride_setup.seed,
        )
        self._marks = RideMarks(end=self._marks.end, begin=(ride, file))


def _name(goal: Destination | None) -> str:
    if goal is None:
        return ""
    return goal.name or f"({goal.x:.1f}, {goal.y:.1f})"


def _longer(durations: Mapping[_K, float], key: _K, dt: float) -> dict[_K, float]:
    return {**durations, key: round(durations.get(key, 0.0) + dt, 6)}
