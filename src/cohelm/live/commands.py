"""Commands of pages put into effect: driver, trip, mode, pace, changes of the simulated world.

All of it runs in the control thread: between two steps, and once more in each before the wheels get
their command. A message with an ``id`` is a request and
gets one answer: ``Accepted``, ``Rejected``, or later ``TripPlans``. Other messages are answered
only if they are rejected.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cohelm.errors import CohelmError
from cohelm.live.control import driver_link
from cohelm.live.control.driver_link import RequiredAction
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.mission import check_goal, check_wish, choice_of, goal_of, wish_of
from cohelm.live.control.world_factory import NotSimulated
from cohelm.live.control_loop import ControlLoop, NotPossibleNow
from cohelm.live.floor_model import FloorModel
from cohelm.live.messages import (
    Accepted,
    ChangeSimulation,
    ChangeStorey,
    FromPage,
    Heartbeat,
    Notice,
    Pace,
    PlanTrip,
    RateRide,
    Rejected,
    ReleaseControl,
    ResumeCommand,
    Role,
    Send,
    SetGoal,
    SetMode,
    SetPace,
    StopCommand,
    TakeControl,
)
from cohelm.live.services import Services
from cohelm.live.sessions.audit import LogEvent
from cohelm.messages import Mode
from cohelm.planning.free_space import check_free_space
from cohelm.reasons import Reason


class NotDriver(CohelmError):
    """Only the driver may request this."""

    code = "not_driver"


class NoDestination(CohelmError):
    """Routes lead to a destination."""

    code = "no_destination"


class StickDeflected(CohelmError):
    """The stick must be released before the driver can confirm."""

    code = Reason.RELEASE_STICK.value


class NoStorey(CohelmError):
    """The chair cannot be on that storey."""

    code = "no_storey"


class NextStorey(NamedTuple):
    """Storey on which the chair is now, and what stays as it is."""

    name: str
    pose: tuple[float, float, float]
    """(x, y, heading) in the map frame, m and rad."""
    mode: Mode
    pace: Pace


class CommandHandler:
    """Changes the driver state as the messages of pages say.

    Args:
        driver: State to change.
        floor: Named places, and the map, which tells where a chair can stand.
        settings: Limits and rider's settings.
        loop: Control loop, whose world pages may change.
        services: Its helpers.
        send: Sends answers and notices.
        log_event: Adds entries to the audit log.
    """

    def __init__(
        self,
        driver: DriverState,
        floor: FloorModel,
        settings: ActiveSettings,
        loop: ControlLoop,
        services: Services,
        *,
        send: Send,
        log_event: LogEvent,
    ) -> None:
        self._driver, self._floor, self._settings = driver, floor, settings
        self._loop, self._services = loop, services
        self._send, self._log_event = send, log_event
        self._wish_count = 0
        self.next_storey: NextStorey | None = None
        """Storey on which the drive is to begin anew; None: no page has said so."""
        self._therapists: set[str] = set()

    def connect(self, client: str, role: Role) -> None:
        """Add a page."""
        if role == "therapist":
            self._therapists.add(client)
        self._log_event(client, "connected", role=role)

    def disconnect(self, client: str) -> None:
        """Remove a page; if it drove, there is no driver now."""
        if client == self._driver.link.driver:
            self._log_event(client, "control_released", reason="disconnected")
        self._therapists.discard(client)
        self._driver.link = driver_link.disconnect(self._driver.link, client)
        self._log_event(client, "disconnected")

    def receive(self, client: str, message: FromPage, at: float) -> None:
        """Process a message, and answer it if it is a request.

        Args:
            client: Page that sent it.
            message: Any message but ``Echo``.
            at: Arrival time, s.
        """
        request_id: int = getattr(message, "id", 0)
        try:
            accepted = HANDLERS[type(message)].handle(self, client, message, at)
        except CohelmError as error:
            text = getattr(error, "problem", None) or str(error)
            self._send(Rejected(id=request_id, code=error.code, text=text), client)
            return
        if accepted:
            self._send(Accepted(id=request_id), client)

    def _on_heartbeat(self, client: str, beat: Heartbeat, at: float) -> bool:
        dead_zone = self._settings.rider.dead_zone
        link = self._driver.link
        self._driver.link = driver_link.on_heartbeat(link, client, beat, at, dead_zone=dead_zone)
        return False

    def _take_control(self, client: str, message: TakeControl, _: float) -> bool:
        driver = self._driver
        before = driver.link.driver
        if before == client:
            return False
        self._settings.over_edges_until = -math.inf
        under_way = driver.mission.under_way
        driver.link = driver_link.take_control(
            driver.link, client, under_way=under_way, confirmed=message.confirm
        )
        self._log_event(client, "control_taken", before=before)
        if before is not None:
            text = "Another screen drives now."
            self._send(Notice(code="control_lost", text=text), before)
            text = "This screen drives now, and the other one no longer."
            self._send(Notice(code="control_taken", text=text), client)
        return False

    def _release_control(self, client: str, _: ReleaseControl, __: float) -> bool:
        if client == self._driver.link.driver:
            self._driver.link = driver_link.release_control(self._driver.link, client)
            self._log_event(client, "control_released")
        return False

    def _stop(self, client: str, _: StopCommand, __: float) -> bool:
        before = self._driver.link
        cause = Reason.RIDER_STOP if client == before.driver else Reason.STOP_PRESSED
        if client in self._therapists:
            cause = Reason.THERAPIST_STOP
        self._driver.stop_until_confirmed(cause)
        self._settings.over_edges_until = -math.inf
        if not (before.required is RequiredAction.CONFIRM and before.cause is cause):
            self._log_event(client, "stop_pressed")  # once, although a page repeats STOP
        return False

    def _resume(self, client: str, _: ResumeCommand, at: float) -> bool:
        before = self._driver.link
        self._driver.link = driver_link.resume(before, client, at)
        if self._driver.link is not before:
            self._log_event(client, "resumed")
        elif client != before.driver:
            raise NotDriver("Only the driver can resume.")
        elif driver_link.status(before, at) in {"stick_held", "centre_stick"}:
            raise StickDeflected(Reason.RELEASE_STICK.sentence)
        return False

    def _check_driver(self, client: str) -> None:
        """Reject a client that does not drive, unless there is no driver."""
        if self._driver.link.driver not in {None, client}:
            raise NotDriver('Another screen drives. Tap "Drive from this screen" first.')

    def _set_goal(self, client: str, message: SetGoal, _: float) -> bool:
        self._check_driver(client)
        goal = goal_of(message.place, message.point, self._floor.places)
        if goal is not None:
            check_goal(goal, self._floor.grid)
        for wish in message.wishes:
            check_wish(wish, self._floor.scene.floor)
        mission = self._driver.mission
        if goal is not None and self._loop.preparing:
            raise NotPossibleNow("Destinations can be chosen once everything is prepared.")
        if goal is None:
            self._driver.mission = mission.with_goal(None)
        else:
            wishes = tuple(wish_of(wish, self._next_wish()) for wish in message.wishes)
            choice = choice_of(message.choice, goal)
            self._driver.mission = mission.with_goal(goal, wishes, choice)
        logged = None if goal is None else goal.name or [round(goal.x, 2), round(goal.y, 2)]
        self._log_event(client, "goal_changed", goal=logged)
        return True

    def _plan_trip(self, client: str, message: PlanTrip, _: float) -> bool:
        goal = goal_of(message.place, message.point, self._floor.places)
        if goal is None:
            raise NoDestination("Choose a destination first.")
        check_goal(goal, self._floor.grid)
        for wish in message.wishes:
            check_wish(wish, self._floor.scene.floor)
        self._services.route_preview.request(client, message, goal, self._settings.person)
        return False

    def _next_wish(self) -> int:
        self._wish_count += 1
        return self._wish_count

    def _set_mode(self, client: str, message: SetMode, _: float) -> bool:
        self._check_driver(client)
        self._driver.mission = replace(self._driver.mission, mode=message.mode)
        self._log_event(client, "mode_changed", mode=message.mode.value)
        return True

    def _set_pace(self, client: str, message: SetPace, _: float) -> bool:
        self._check_driver(client)
        self._driver.mission = replace(self._driver.mission, pace=message.pace)
        self._log_event(client, "pace_changed", pace=message.pace)
        return True

    def _rate_ride(self, _: str, message: RateRide, __: float) -> bool:
        self._services.rides.rate(message.ride, message.rating)
        return True

    def _change_simulation(self, client: str, message: ChangeSimulation, _: float) -> bool:
        self._check_driver(client)
        cycle = self._loop.cycle
        world, route = cycle.world, cycle.state.view.route
        if world is not None and not world.simulated:
            raise NotSimulated("Only a simulation can do that.")
        if message.action == "restart":
            self._loop.restart_world(message.seed)
        elif world is None:
            raise NotPossibleNow(Reason.STARTING.sentence)
        elif message.action == "pause":
            cycle.pause(on=message.on)
        else:
            world.change(message, np.array(route.points).reshape(-1, 2))
        self._log_event(client, "simulation_changed", action=message.action)
        return True

    def _change_storey(self, client: str, message: ChangeStorey, _: float) -> bool:
        self._check_driver(client)
        cycle, floor, name = self._loop.cycle, self._floor, message.storey
        if cycle.world is None or not cycle.world.simulated:
            raise NotSimulated("Only a simulation can do that.")
        if cycle.moves:
            raise NotPossibleNow("The storey can be changed only while the chair stands.")
        grids = [each.grid for each in floor.storeys if each.name == name != floor.scene.storey]
        if not grids:
            raise NoStorey(f"There is no other storey {name}.")
        x, y, heading = cycle.world.observation.pose.tolist()
        if not check_free_space(grids[0], floor.robot, (x, y), heading).fits:
            raise NoStorey(f"On {name} there is no free floor here: drive to a lift first.")
        mission = self._driver.mission
        self.next_storey = NextStorey(name, (x, y, heading), mission.mode, mission.pace)
        self._log_event(client, "storey_changed", storey=name)
        self._loop.announce("storey_changes", f"The map changes to {name}.")
        return True


class Handler(NamedTuple):
    """Handling of one type of message."""

    handle: Callable[[CommandHandler, str, Any, float], bool]
    """Puts it into effect; returns True to answer ``Accepted``, raises CohelmError to reject it."""
    slow: bool = False
    """True if it may take longer than a step has time for; see ``ControlLoop.submit``."""


HANDLERS: Mapping[type, Handler] = {
    Heartbeat: Handler(CommandHandler._on_heartbeat),
    TakeControl: Handler(CommandHandler._take_control),
    ReleaseControl: Handler(CommandHandler._release_control),
    StopCommand: Handler(CommandHandler._stop),
    ResumeCommand: Handler(CommandHandler._resume),
    PlanTrip: Handler(CommandHandler._plan_trip),
    SetGoal: Handler(CommandHandler._set_goal),
    SetMode: Handler(CommandHandler._set_mode),
    SetPace: Handler(CommandHandler._set_pace),
    RateRide: Handler(CommandHandler._rate_ride),
    ChangeSimulation: Handler(CommandHandler._change_simulation, slow=True),
    ChangeStorey: Handler(CommandHandler._change_storey, slow=True),
}
"""All messages of ``FromPage`` but ``Echo``, which ``Drive`` returns without the control thread."""
