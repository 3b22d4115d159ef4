"""Rides of a drive: their beginnings, ends and summaries."""

from __future__ import annotations

import contextlib
import logging
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from math import isfinite
from typing import NamedTuple, TypeVar

from cohelm.errors import StoreError
from cohelm.live.control.ipc import RideBegin
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.mission import Mission
from cohelm.live.messages import Destination, Device, RideEnded, RideOutcome, Send
from cohelm.live.sessions.records import LimitsAt, RideLog, RideSummary
from cohelm.live.sessions.session_files import session_of
from cohelm.live.sessions.store import SessionStore
from cohelm.messages import Decision, Mode
from cohelm.planning.alternatives.learned_preference import RouteChoice
from cohelm.scenarios import RideSetup

_log = logging.getLogger(__name__)
_K = TypeVar("_K")
CHECKPOINT_PERIOD = 1.0
"""Time between two stored summaries of a ride that goes on, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RideMarks:
    """End and beginning of rides, in this order, for one request to the navigator's process."""

    end: RideOutcome | None = None
    """The ride that has begun before has ended."""
    begin: RideBegin | None = None


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

    def summary(self, outcome: RideOutcome, log: RideLog | None) -> RideSummary:
        """Return the record to store.

        Args:
            outcome: Outcome of the ride.
            log: Log by the navigator's process; None: that process was lost.
        """
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
            stops=log.stops if log is not None else (),
            nearest=round(log.nearest, 3) if log is not None and isfinite(log.nearest) else None,
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
        self._store_fails = False
        """True from a failure of the store until the chair stands."""
        self._error = ""
        self._saved_at = 0.0
        """Duration of the ride at its last checkpoint, s."""

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
        return self._error or self._store.error

    def retry(self) -> None:
        """Store again what could not be stored, without waiting for it."""
        if self._store.error or self._settings.error:
            self._store.retry(self._settings.retry)
        if not self._store_fails:  # the chair stands, or its ride is stored
            self._open_session()

    def enter(self, ride_setup: RideSetup) -> None:
        """End the current ride; further rides take place in this world."""
        self.end("cancelled")
        self._ride_setup = ride_setup
        self._open_session()

    def take_marks(self) -> RideMarks:
        """Return the marks for the next request to the navigator, each only once."""
        return self._marks.popleft() if self._marks else RideMarks()

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
        self._store_fails &= bool(command.twist.any())
        if self._ride is None and command.twist.any() and not self._store_fails:
            self._begin()
        if self._ride is not None:
            limits = LimitsAt(time=self._ride.time, limits=self._settings.limits)
            self._ride = self._ride.after(elapsed, length, mission, device, limits)
            if self._ride.time - self._saved_at >= CHECKPOINT_PERIOD:
                self._saved_at = self._ride.time
                self._store.checkpoint(self._ride.summary("cancelled", None))

    def end(self, outcome: RideOutcome) -> None:
        """End the current ride, if there is one."""
        ride, self._ride = self._ride, None
        if ride is None or self._ride_setup is None:
            return
        self._send(ride.ended(outcome), None)
        self._ended[ride.id] = _EndedRide(ride, outcome, self._ride_setup)
        self._marks.append(RideMarks(end=outcome))

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
        self._store.keep(ride.summary(outcome, log), log, ride_setup)
        rating = self._ratings.pop(ride.id, None)
        if rating is not None:
            with contextlib.suppress(StoreError):  # its session was deleted meanwhile
                self._store.rate(ride.id, rating)

    def _open_session(self) -> None:
        """Begin the session before its first ride, so that a full disk is said before it."""
        if self._ride_setup is None or self._session_rider == self._settings.person:
            return
        try:
            self._begin_session(self._ride_setup)
        except StoreError as error:
            if not self._error:  # once, not at every attempt
                _log.error("rides are not stored: %s", error)
            self._error = error.problem
        else:
            self._error = ""

    def _begin_session(self, ride_setup: RideSetup) -> None:
        """Begin the session of this drive and rider, unless it has begun.

        Raises:
            StoreError: The session cannot be written.
        """
        rider = self._settings.person
        if self._session_rider != rider:
            self._store.begin(ride_setup, rider)
            self._session_rider = rider

    def _begin(self) -> None:
        if self._ride_setup is None:
            return
        try:
            self._begin_session(self._ride_setup)
            ride, rows = self._store.begin_ride()
        except StoreError as error:
            _log.error("a ride is not stored: %s", error)
            self._store_fails, self._error = True, error.problem
            return
        self._error, self._saved_at = "", 0.0
        self._ride = LiveRide(
            id=ride,
            started=datetime.now(UTC).isoformat(timespec="seconds"),
            seed=self._ride_setup.seed,
        )
        self._store.checkpoint(self._ride.summary("cancelled", None), self._ride_setup)
        # One request can carry an end and the beginning after it, but not the other order.
        end = None
        if self._marks and self._marks[-1].begin is None:
            end = self._marks.pop().end
        self._marks.append(RideMarks(end=end, begin=RideBegin(ride, rows)))


def _name(goal: Destination | None) -> str:
    if goal is None:
        return ""
    return goal.name or f"({goal.x:.1f}, {goal.y:.1f})"


def _longer(durations: Mapping[_K, float], key: _K, dt: float) -> dict[_K, float]:
    return {**durations, key: round(durations.get(key, 0.0) + dt, 6)}
