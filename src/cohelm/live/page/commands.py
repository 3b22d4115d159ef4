"""Commands of pages put into effect: driver, destination, wishes, mode and pace.

All of it runs in the control thread, between two steps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Protocol

from cohelm.errors import CohelmError
from cohelm.live.control import link
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.mission import MAX_WISHES, Mission, check_wish, goal_of, wish_of
from cohelm.live.messages import (
    Accepted,
    AddWish,
    ChangeSimulation,
    FloorInfo,
    FromPage,
    Heartbeat,
    Notice,
    RateRide,
    Rejected,
    ReleaseControl,
    RemoveWish,
    ResumeCommand,
    Role,
    SetGoal,
    SetMode,
    SetPace,
    StopCommand,
    TakeControl,
    ToPage,
)
from cohelm.live.sessions.audit import AuditEvent
from cohelm.maps import Places
from cohelm.reasons import Reason

Send = Callable[[ToPage, str | None], None]
"""Sends a message to a client; None: to all."""


class LogEvent(Protocol):
    """Adds an entry to the audit log."""

    def __call__(self, actor: str, event: AuditEvent, **details: Any) -> None:
        """See ``AuditLog.log_event``."""
        ...


class CommandEffects(Protocol):
    """Commands that need the control loop; a CohelmError rejects one."""

    def change_simulation(self, command: ChangeSimulation) -> None:
        """Change the simulated world."""
        ...

    def preview(self, client: str, wish: AddWish) -> None:
        """Request the cost of a wish; the answer comes later."""
        ...

    def rate(self, ride: str, rating: int) -> None:
        """Store the rating of a ride."""
        ...


class NotDriver(CohelmError):
    """Only the driver may request this."""

    code = "not_driver"


class TooManyActiveWishes(CohelmError):
    """The maximum number of wishes is active already."""

    code = Reason.TOO_MANY_WISHES.value


class Commands:
    """Link and mission, changed by the messages of pages.

    Args:
        places: Named places.
        settings: Limits and rider's settings.
        send, log_event: Message listener and audit log.
        effects: Commands that need the control loop.
        floor: Bounds the wishes; None: no bounds.
    """

    def __init__(
        self,
        places: Places,
        settings: ActiveSettings,
        send: Send,
        log_event: LogEvent,
        effects: CommandEffects,
        floor: FloorInfo | None = None,
    ) -> None:
        self._floor = floor
        self.link = link.LinkState()
        self.mission = Mission()
        self._places, self._settings = places, settings
        self._send, self._log_event, self._effects = send, log_event, effects
        self._wish_count = 0
        # Messages without an answer …
        self._events: Mapping[type, Callable[[str, Any, float], None]] = {
            Heartbeat: self._heartbeat,
            TakeControl: self._take_control,
            ReleaseControl: self._release_control,
            StopCommand: self._stop,
            ResumeCommand: self._resume,
        }
        # … and requests, which are accepted or rejected.
        self._requests: Mapping[type, Callable[[str, Any], bool]] = {
            SetGoal: self._set_goal,
            AddWish: self._add_wish,
            RemoveWish: self._remove_wish,
            SetMode: self._set_mode,
            SetPace: self._set_pace,
            RateRide: self._rate_ride,
            ChangeSimulation: self._change_simulation,
        }

    def connect(self, client: str, role: Role) -> None:
        """Add a page."""
        self._log_event(client, "connected", role=role)

    def disconnect(self, client: str) -> None:
        """Remove a page; if it drove, there is no driver now."""
        if client == self.link.driver:
            self._log_event(client, "control_released", reason="disconnected")
        self.link = link.disconnect(self.link, client)
        self._log_event(client, "disconnected")

    def receive(self, client: str, message: FromPage, at: float) -> None:
        """Process a message that arrived at ``at``, s; requests are answered."""
        event = self._events.get(type(message))
        if event is not None:
            event(client, message, at)
            return
        request = self._requests.get(type(message))
        if request is None:
            return
        number: int = message.id  # type: ignore[union-attr]  # all requests have one
        try:
            if request(client, message):
                self._send(Accepted(id=number), client)
        except CohelmError as error:
            self._reject(client, number, error)

    def _reject(self, client: str, number: int, error: CohelmError) -> None:
        text = getattr(error, "problem", None) or str(error)
        self._send(Rejected(id=number, code=error.code, text=text), client)

    def _heartbeat(self, client: str, beat: Heartbeat, at: float) -> None:
        dead_zone = self._settings.rider.dead_zone
        self.link = link.on_heartbeat(self.link, client, beat, at, dead_zone=dead_zone)

    def _take_control(self, client: str, _: TakeControl, __: float) -> None:
        before = self.link.driver
        if before == client:
            return
        self.link = link.take_control(self.link, client, under_way=self.mission.under_way)
        self._log_event(client, "control_taken", before=before)
        if before is not None:
            text = "Another screen has taken control."
            self._send(Notice(code="control_lost", text=text), before)
            text = "You have taken control from another screen."
            self._send(Notice(code="control_taken", text=text), client)

    def _release_control(self, client: str, _: ReleaseControl, __: float) -> None:
        if client == self.link.driver:
            self.link = link.release_control(self.link, client)
            self._log_event(client, "control_released")

    def _stop(self, client: str, _: StopCommand, __: float) -> None:
        before = self.link
        self.link = link.stop_until_confirmed(before, Reason.RIDER_STOP)
        stopped = before.cause is Reason.RIDER_STOP
        if not (before.required is link.RequiredAction.CONFIRM and stopped):
            self._log_event(client, "stop_pressed")  # once, although a page repeats STOP

    def _resume(self, client: str, _: ResumeCommand, at: float) -> None:
        after = link.resume(self.link, client, at)
        if after is not self.link:
            self.link = after
            self._log_event(client, "resumed")
            return
        found = link.status(self.link, at)
        if client != self.link.driver:
            self._reject(client, 0, NotDriver("Only the driver can resume."))
        elif found in {"stick_held", "centre_stick"}:
            release = Reason.RELEASE_STICK
            self._send(Rejected(code=release.value, text=release.sentence), client)

    def _check_driver(self, client: str) -> None:
        """Reject a client that does not drive, unless there is no driver."""
        if self.link.driver not in {None, client}:
            raise NotDriver("Another screen drives. Take control first.")

    def _set_goal(self, client: str, message: SetGoal) -> bool:
        self._check_driver(client)
        goal = goal_of(message.place, message.point, self._places)
        self.mission = self.mission.with_goal(goal)
        logged = None if goal is None else goal.name or [round(goal.x, 2), round(goal.y, 2)]
        self._log_event(client, "goal_changed", goal=logged)
        return True

    def _add_wish(self, client: str, message: AddWish) -> bool:
        if self._floor is not None:
            check_wish(message, self._floor)
        if message.preview:
            wish_of(message, 0)
            self._effects.preview(client, message)
            return False
        self._check_driver(client)
        if len(self.mission.wishes) >= MAX_WISHES:
            raise TooManyActiveWishes(Reason.TOO_MANY_WISHES.sentence)
        wish = wish_of(message, self._wish_count + 1)
        self._wish_count += 1
        self.mission = self.mission.with_wish(wish)
        return True

    def _remove_wish(self, client: str, message: RemoveWish) -> bool:
        self._check_driver(client)
        self.mission = self.mission.without_wish(message.wish, every=message.all)
        return True

    def _set_mode(self, client: str, message: SetMode) -> bool:
        self._check_driver(client)
        self.mission = replace(self.mission, mode=message.mode)
        self._log_event(client, "mode_changed", mode=message.mode.value)
        return True

    def _set_pace(self, client: str, message: SetPace) -> bool:
        self._check_driver(client)
        self.mission = replace(self.mission, pace=message.pace)
        self._log_event(client, "pace_changed", pace=message.pace)
        return True

    def _rate_ride(self, _: str, message: RateRide) -> bool:
        self._effects.rate(message.ride, message.rating)
        return True

    def _change_simulation(self, client: str, message: ChangeSimulation) -> bool:
        self._check_driver(client)
        self._effects.change_simulation(message)
        self._log_event(client, "simulation_changed", action=message.action)
        return True
