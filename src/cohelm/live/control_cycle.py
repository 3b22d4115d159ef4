"""Control cycle: from the observation to the wheels, whatever fails.

t       messages of pages; the valid heartbeat goes into the observation, and that to the navigator
…       its answer, awaited as long as the step allows
t + c   command for the wheels: the answer, or a stop by link, watchdog or another hold; the
        platform gets the command, pages get the state (a simulation first shows, then moves)
t + T   next step (``step_timing``)
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace

from cohelm.live.control import driver_link
from cohelm.live.control.cycle_state import CycleState, PageView
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.ipc import StepAnswer
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.readiness import KEPT, acknowledges, held_by, not_ready
from cohelm.live.control.step_requests import UnsentReadings, step_request
from cohelm.live.control.step_timing import STEP, answer_deadline, elapsed_time
from cohelm.live.control.time_rate import ABSORBED_LATENESS
from cohelm.live.control.watchdog import (
    INPUT_FAULTS,
    MAX_ANSWER_LATENCY,
    Watchdog,
    limit_acceleration,
)
from cohelm.live.control.world_factory import LiveWorld
from cohelm.live.messages import ChairState, Notice, Preparing, RouteUpdate, Send
from cohelm.live.page.state_messages import SLOW_NOTICE, reason_of, reason_text, world_fields
from cohelm.live.services import Services
from cohelm.messages import RiderProfile
from cohelm.reasons import Reason
from cohelm.safety import stop

_STATE_PERIOD = 5
"""Steps between two states without a world: what compiles has the computer's time."""


class ControlCycle:
    """Chair in its world with the navigator; belongs to the control thread.

    Args:
        driver: Link and mission.
        settings: Limits and rider's settings.
        profile: Profile of the scenario's rider.
        services: Helpers.
        send: Sends messages to pages.
        unstored: Returns what cannot be stored, and why; empty: everything is.
        clock: Monotonic clock, s.
    """

    def __init__(
        self,
        driver: DriverState,
        settings: ActiveSettings,
        profile: RiderProfile,
        services: Services,
        *,
        send: Send,
        unstored: Callable[[], str] = lambda: "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._driver, self._settings = driver, settings
        self._given = driver, settings, profile
        self._navigator, self._rides = services.navigator, services.rides
        self._route_preview = services.route_preview
        self._send, self._clock, self._unstored = send, clock, unstored
        self.state = CycleState()
        self.world: LiveWorld | None = None
        self.preparing: Preparing | None = None
        """Progress of compiling; None: everything is compiled."""
        self.load_routes = False
        """Let the navigator load the code of routes, once the chair stands and nobody steers."""
        self._unsent = UnsentReadings()
        self._sent = PageView(route=RouteUpdate(version=-1))
        """Route, differences and edges that pages have already."""

    @property
    def moves(self) -> bool:
        """True if the chair moves, or has a command to move."""
        if self.world is None:
            return False
        return bool(self.state.command.twist.any()) or not self.world.stands

    @property
    def behind(self) -> bool:
        """True if readings of a real chair wait, and the navigator is free: step at once."""
        real = self.world is not None and not self.world.simulated
        return real and self._navigator.free and self._unsent.waiting

    @property
    def _routable(self) -> bool:
        return self._navigator.ready and self._navigator.routes

    def enter(self, world: LiveWorld) -> None:
        """Put the chair into another world, where it stands without a destination.

        A destination chosen before there was a world is kept.
        """
        restarted = self.world is not None
        self.world = world
        self.state = self.state.entered(simulated=world.simulated)
        self._unsent.clear()
        self._settings.over_edges_until = -math.inf
        if restarted:
            self._driver.clear_mission()
        if world.simulated:
            self._driver.require_centring()
        else:  # a real chair moves only after the rider has said so
            self._driver.stop_until_confirmed(Reason.CONFIRM)
        self._rides.enter(world.ride_setup)

    def await_world(self, *, on: bool) -> None:
        """Let the chair stand until another world is built, or no longer."""
        self.state = replace(self.state, awaits_world=on)

    def pause(self, *, on: bool) -> None:
        """Pause the simulation, or resume it; then the stick must be centred first."""
        state = self.state
        if state.paused and not on:
            self._driver.require_centring()
            # Else the last decision would count as too old, and the driver had to confirm.
            watchdog = replace(state.watchdog, at=self._clock())
            state = replace(state, watchdog=watchdog, time_rate=state.time_rate.resumed())
        self.state = replace(state, paused=on)

    def navigator_restarted(self) -> None:
        """Forget the old navigator's decisions: the new one has no memory."""
        self.state = replace(
            self.state,
            restart=True,
            watchdog=Watchdog(),
            answered_mission=-1,
            loading_routes=-1,
        )

    def step(self, due: float, run_calls: Callable[[], None]) -> None:
        """Run one control step.

        Args:
            due: Time at which it should have begun, s.
            run_calls: Puts commands of pages into effect; called again before the wheels.
        """
        run_calls()
        late = max(self._clock() - due, 0.0)
        world = self.world
        if world is not None and self.state.paused:
            self._step_paused(world)
        elif world is not None:
            if world.simulated:
                rate = self.state.time_rate.stepped(STEP, self._clock())
                self.state = replace(self.state, time_rate=rate)
            self._driver.sense(world, self._clock(), dead_zone=self._settings.rider.dead_zone)
            self._await_answer(world, answer_deadline(due, late, simulated=world.simulated), late)
            run_calls()
        if world is not self.world:
            return  # a command has replaced the world
        now = self._clock()
        elapsed = self._select_command(now)
        real = world is not None and not world.simulated
        slow = world is None and self.state.ticks % _STATE_PERIOD > 0
        if not real and not slow:  # pages see the simulated world that was decided about
            self._send_state(world, now, late)
        if world is not None and not self.state.paused:
            self._advance(world, elapsed)
        if real:  # the wheels do not wait for pages
            self._send_state(world, now, late)
        self.state = replace(self.state, ticks=self.state.ticks + 1)

    def step_failed(self) -> None:
        """Stop after a failure of the loop: first the world, since the message may fail as well."""
        command, ticks = stop(Reason.PROGRAM_FAILED), self.state.ticks + 1
        self.state = replace(self.state, command=command, heartbeat_seq=-1)
        world, now = self.world, self._clock()
        try:
            if world is not None and not self.state.paused:
                world.apply(command)
        finally:  # a lost chair takes no command, and pages must know all the more
            self.state = replace(self.state, ticks=ticks)
            self._send_state(world, now, late=0.0)

    def _request_step(self, world: LiveWorld, late: float) -> bool:
        """Send the newest observation if the navigator is free; returns True if it was sent."""
        now, link, state = self._clock(), self._driver.link, self.state
        time = world.time(now)
        if not self._navigator.free or time <= state.requested_time:
            return False  # it is sent once: simulated time may be slower than the steps
        moves = driver_link.status(link, now) == "ready"
        known = acknowledges(link, state.watchdog, state.requested_epoch)
        request = step_request(state.ticks, world, *self._given, now=now, moves=moves, stop=known)
        marks, seen = self._rides.take_marks(), self._unsent.take(request.observation)
        request = replace(
            request,
            observation=replace(seen, late=max(late - ABSORBED_LATENESS, 0.0)),
            restart=state.restart,
            end=marks.end,
            begin=marks.begin,
            summary=marks.summary,
            planning_context=self._route_preview.needs_context,
            load_routes=self.load_routes
            and not (self._navigator.routes or self.moves)
            and math.hypot(*driver_link.deflection(link, now)) <= self._settings.rider.dead_zone,
        )
        if request.load_routes:
            state = replace(state, loading_routes=state.ticks)
        self.state = replace(state, restart=False, requested_time=time, requested_epoch=link.epoch)
        self._navigator.request(request, now)
        return self._navigator.ready

    def _step_paused(self, world: LiveWorld) -> None:
        """Take a late answer, and request the planning context of a route preview."""
        now = self._clock()
        answer = self._navigator.answer(0.0, now)
        if answer is not None:
            self._take_answer(world, answer)
        if self._route_preview.needs_context and self._navigator.free:
            request = step_request(self.state.ticks, world, *self._given, now=now, moves=False)
            self._navigator.request(replace(request, paused=True, planning_context=True), now)

    def _await_answer(self, world: LiveWorld, until: float, late: float) -> None:
        """Request the step, and take answers until ``until``, s, or until its own has come.

        The late answer to an older step moves a real chair at once, before the next request.
        """
        sent = self._request_step(world, late)
        while self._navigator.pending is not None:
            now = self._clock()
            answer = self._navigator.answer(max(until - now, 0.0), now)
            if answer is None:
                break
            self._take_answer(world, answer)
            own = answer.step_id == self.state.ticks
            if own or self._clock() >= until or not world.simulated:
                break
            sent = self._request_step(world, late)
        new = world.time(self._clock()) > self.state.requested_time
        # The navigator did not get this observation: keep its scans for the next request.
        if not sent and new and self.state.time_rate.advances:
            self._unsent.keep(world.observation)

    def _take_answer(self, world: LiveWorld, answer: StepAnswer) -> None:
        """Use an answer; one that comes too late decides about no motion."""
        driver, now, state = self._driver, self._clock(), self.state
        self._rides.add_log(answer.log)
        loading = answer.step_id == state.loading_routes
        if loading:
            self._navigator.routes = True
            # Else the last decision would count as too old, and the driver had to confirm.
            watchdog = replace(state.watchdog, at=self._clock())
            self.state = state = replace(state, loading_routes=-1, watchdog=watchdog)
            self._driver.require_centring()
        if answer.step_id < state.first_step_id:
            return  # from the previous world
        if answer.planning_context is not None:
            self._route_preview.set_planning_context(answer.planning_context)
        if answer.state is None:
            return
        rate, watchdog, time = state.time_rate, state.watchdog, world.time(now)
        if world.simulated and not loading:
            rate = rate.answered(now - self._navigator.requested_at, now)
        if time - state.requested_time <= MAX_ANSWER_LATENCY + 1e-6:
            watchdog = Watchdog.of(answer, now, time, state.requested_epoch)
        reason = answer.decision.reason
        faulty = reason in (KEPT if world.simulated else KEPT | INPUT_FAULTS)
        if faulty and driver_link.status(driver.link, now) == "ready":
            driver.stop_until_confirmed(reason or Reason.CONFIRM)
        self.state = replace(
            state,
            unstored_rows=answer.unstored,
            time_rate=rate,
            watchdog=watchdog,
            answered_mission=answer.mission_version,
            view=state.view.updated(answer, answer.state, driver.mission),
        )
        current = answer.mission_version == driver.mission.version
        if answer.arrived and current and driver.mission.goal is not None and world.stands:
            self.state = replace(self.state, arrived=True)
            self._rides.end("arrived")
            self._send(Notice(code="arrived", text=driver.arrive()), None)

    def _select_command(self, now: float) -> float:
        """Set the decision at the wheels; returns the time since the last one, s."""
        state, driver, world = self.state, self._driver, self.world
        watchdog, simulated = state.watchdog, world is None or world.simulated
        passed = elapsed_time(state.commanded_at, now)
        elapsed = STEP * state.time_rate.advances if simulated else passed
        if state.paused:
            self.state = replace(state, commanded_at=now, command=stop(Reason.PAUSED))
            return elapsed
        no_decision = watchdog.decision is None and self._navigator.starts <= 1
        starting = state.awaits_world or no_decision or state.loading_routes >= 0
        if state.starting and not starting:
            driver.require_confirmation_of_trip()
        hold_reason = held_by(driver.link, watchdog, now, starting=starting)
        if not starting and watchdog.silent(now, simulated=simulated):
            driver.stop_until_confirmed(Reason.NAVIGATOR_TIMEOUT)
        selected = watchdog.select_command(0.0 if world is None else world.time(now), hold_reason)
        newest = driver_link.current_heartbeat(driver.link, now).seq
        stops = selected.reason is Reason.NAVIGATOR_TIMEOUT and bool(state.command.twist.any())
        limit = self._settings.limits.max_acceleration
        self.state = replace(
            state,
            starting=starting,
            commanded_at=now,
            command=limit_acceleration(selected, state.command.twist, limit, elapsed),
            heartbeat_seq=watchdog.heartbeat_seq if hold_reason is None else newest,
            stops=state.stops + stops,
        )
        return elapsed

    def _advance(self, world: LiveWorld, elapsed: float) -> None:
        """Send the command to the wheels, and react to contacts."""
        state, driver = self.state, self._driver
        if not state.time_rate.advances:
            return
        length = world.apply(state.command)
        self._rides.step(
            state.command,
            driver.mission,
            elapsed=elapsed,
            length=length,
            device=driver_link.current_heartbeat(driver.link, self._clock()).device,
        )
        accident = world.accident
        if accident is not None and not state.touching:
            driver.stop_until_confirmed(accident)
            self._rides.end("fell" if accident is Reason.FELL else "collision")
            self._send(Notice(code=accident.value, text=accident.sentence), None)
        arrived = state.arrived and not state.command.twist.any()
        self.state = replace(state, arrived=arrived, touching=accident is not None)
        if driver.link.driver is None:
            self._rides.end("cancelled")

    def _send_state(self, world: LiveWorld | None, now: float, late: float) -> None:
        view, sent, self._sent = self.state.view, self._sent, self.state.view
        if view.route != sent.route:
            self._send(view.route, None)
        if view.differences != sent.differences:
            self._send(view.differences, None)
        if view.edges != sent.edges:
            self._send(view.edges, None)
        if self.state.time_rate.notice:
            self._send(SLOW_NOTICE, None)
        self._send(self._state_message(world, now, late), None)

    def _state_message(self, world: LiveWorld | None, now: float, late: float) -> ChairState:
        """State of the chair.

        Args:
            world: World of the ride; None: not built yet.
            now: Time just before the command was selected, s.
            late: Delay of the step's start, s.
        """
        state, link, mission = self.state, self._driver.link, self._driver.mission
        status, command = driver_link.status(link, now), state.command
        fault = not_ready(
            *(command.reason, self._navigator, state.watchdog, now),
            mode=mission.active_mode,
            simulated=world is None or world.simulated,
        )
        required = driver_link.required_reason(status)
        forward, _, turn = command.twist.tolist()
        hidden = {"remaining": None} if mission.goal is None else {"offers": ()}
        return ChairState.model_construct(
            **(dict(state.view.navigator) | hidden),
            **world_fields(world),
            seq=state.ticks,
            command=(round(forward, 4), round(turn, 4)),
            heartbeat=state.heartbeat_seq,
            driver=link.driver,
            device=driver_link.current_heartbeat(link, now).device,
            link=status,
            mode=mission.mode,
            pace=mission.pace,
            reason=reason_text(command, required),
            not_ready=None if fault is None else reason_of(fault, fault.sentence),
            can_plan=world is not None and self._routable and self._route_preview.ready,
            preparing=self.preparing,
            arrived=state.arrived,
            paused=state.paused,
            goal=mission.goal,
            route_version=state.view.route.version,
            ride=self._rides.ride,
            lateness=round(1000.0 * late, 1),
            rate=round(state.time_rate.measured, 2),
            unstored=self._unstored(),
            clock=round(now, 4),
        )
