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
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.ipc import StepAnswer
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.readiness import KEPT, acknowledges, held_by, not_ready
from cohelm.live.control.step_requests import UnsentReadings, step_request
from cohelm.live.control.step_timing import STEP, answer_deadline, elapsed_time
from cohelm.live.control.time_rate import ABSORBED_LATENESS, TimeRate
from cohelm.live.control.watchdog import (
    INPUT_FAULTS,
    MAX_ANSWER_LATENCY,
    Watchdog,
    limit_acceleration,
)
from cohelm.live.control.world_factory import LiveWorld
from cohelm.live.messages import Notice, Send
from cohelm.live.page.state_messages import SLOW_NOTICE, PageView, Sent, StepStatus, state_message
from cohelm.live.services import Services
from cohelm.messages import RiderProfile
from cohelm.reasons import Reason
from cohelm.safety import stop


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
        self.unstored_rows = ""  # reason why the navigator's process stores no rows
        self.time_rate = TimeRate()
        self._requested_time = -math.inf  # ``LiveWorld.time`` of the last observation sent, s
        self.world: LiveWorld | None = None
        self._starting = True  # until the navigator has made a decision in this world
        self.paused = False
        """True while the simulation is paused."""
        self.awaits_world = False
        """True while another world is built; until then the chair stands."""
        self._restart, self._first_step_id = False, 0
        """True if the next request restarts the navigator; first step in this world."""
        self._watchdog = Watchdog()
        self.view = PageView()
        self._sent = Sent()
        self.command = stop(Reason.STARTING)
        """Decision at the wheels."""
        self.starting_text = ""
        """Additional text while the chair starts."""
        self._heartbeat_seq, self._requested_epoch = -1, 0
        """``Heartbeat.seq`` behind the command; ``LinkState.epoch`` at the last request."""
        self._unsent = UnsentReadings()
        self._commanded_at = -math.inf  # time of the last command for the wheels, s
        self._touching = False  # the chair is in contact with something
        self.arrived = False
        """True from an arrival to the next motion."""
        self.ticks = 0
        self.answered_mission = -1  # ``Mission.version`` of the last answer; −1: none yet
        self.stops = 0
        """Number of stops by the watchdog."""

    @property
    def moves(self) -> bool:
        """True if the chair moves, or has a command to move."""
        if self.world is None:
            return False
        return bool(self.command.twist.any()) or not self.world.stands

    @property
    def behind(self) -> bool:
        """True if readings of a real chair wait, and the navigator is free: step at once."""
        real = self.world is not None and not self.world.simulated
        return real and self._navigator.free and self._unsent.waiting

    def enter(self, world: LiveWorld) -> None:
        """Put the chair into another world, where it stands without a destination.

        A destination chosen before there was a world is kept.
        """
        restarted = self.world is not None
        self.world, self.paused, self.awaits_world = world, False, False
        self._restart, self._first_step_id = True, self.ticks
        self._requested_time = -math.inf
        self.time_rate = self.time_rate.resumed() if world.simulated else TimeRate()
        version = self.view.route_version + 1
        self._watchdog, self.view = Watchdog(), PageView(route_version=version)
        self._unsent.clear()
        self._touching = self.arrived = False
        self.command = stop(Reason.STARTING)
        if restarted:
            self._driver.clear_mission()
        if world.simulated:
            self._driver.require_centring()
        else:  # a real chair moves only after the rider has said so
            self.stop_until_confirmed(Reason.CONFIRM)
        self._rides.enter(world.ride_setup)

    def pause(self, *, on: bool) -> None:
        """Pause the simulation, or resume it; then the stick must be centred first."""
        if self.paused and not on:
            self._driver.require_centring()
            # Else the last decision would count as too old, and the driver had to confirm.
            self._watchdog = replace(self._watchdog, at=self._clock())
            self.time_rate = self.time_rate.resumed()
        self.paused = on

    def navigator_restarted(self) -> None:
        """Forget the old navigator's decisions: the new one has no memory."""
        self._restart, self._watchdog, self.answered_mission = True, Watchdog(), -1

    def stop_until_confirmed(self, cause: Reason) -> None:
        """Stop until the driver confirms."""
        self._driver.stop_until_confirmed(cause)

    def step(self, due: float, run_calls: Callable[[], None]) -> None:
        """Run one control step.

        Args:
            due: Time at which it should have begun, s.
            run_calls: Puts commands of pages into effect; called again before the wheels.
        """
        run_calls()
        late = max(self._clock() - due, 0.0)
        world = self.world
        if world is not None and self.paused:
            self._step_paused(world)
        elif world is not None:
            if world.simulated:
                self.time_rate = self.time_rate.stepped(STEP, self._clock())
            self._driver.sense(world, self._clock(), dead_zone=self._settings.rider.dead_zone)
            self._await_answer(world, answer_deadline(due, late, simulated=world.simulated), late)
            run_calls()
        if world is not self.world:
            return  # a command has replaced the world
        now = self._clock()
        elapsed = self._select_command(now)
        real = world is not None and not world.simulated
        if not real:  # pages see the simulated world that was decided about
            self._send_state(world, now, late)
        if world is not None and not self.paused:
            self._advance(world, elapsed)
        if real:  # the wheels do not wait for pages
            self._send_state(world, now, late)
        self.ticks += 1

    def step_failed(self) -> None:
        """Stop after a failure of the loop: first the world, since the message may fail as well."""
        self.command = stop(Reason.PROGRAM_FAILED)
        self._heartbeat_seq = -1
        world, now = self.world, self._clock()
        if world is not None and not self.paused:
            world.apply(self.command)
        self.ticks += 1
        self._send_state(world, now, late=0.0)

    def _request_step(self, world: LiveWorld, late: float) -> bool:
        """Send the newest observation if the navigator is free; returns True if it was sent."""
        now, link = self._clock(), self._driver.link
        time = world.time(now)
        if not self._navigator.free or time <= self._requested_time:
            return False  # it is sent once: simulated time may be slower than the steps
        self._requested_time = time
        moves = driver_link.status(link, now) == "ready"
        known = acknowledges(link, self._watchdog, self._requested_epoch)
        request = step_request(self.ticks, world, *self._given, now=now, moves=moves, stop=known)
        marks, seen = self._rides.take_marks(), self._unsent.take(request.observation)
        request = replace(
            request,
            observation=replace(seen, late=max(late - ABSORBED_LATENESS, 0.0)),
            restart=self._restart,
            end=marks.end,
            begin=marks.begin,
            planning_context=self._route_preview.needs_context,
        )
        self._restart = False
        self._requested_epoch = link.epoch
        self._navigator.request(request, now)
        return self._navigator.ready

    def _step_paused(self, world: LiveWorld) -> None:
        """Take a late answer, and request the planning context of a route preview."""
        now = self._clock()
        answer = self._navigator.answer(0.0, now)
        if answer is not None:
            self._take_answer(world, answer)
        if self._route_preview.needs_context and self._navigator.free:
            request = step_request(self.ticks, world, *self._given, now=now, moves=False)
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
            if answer.step_id == self.ticks or self._clock() >= until or not world.simulated:
                break
            sent = self._request_step(world, late)
        new = world.time(self._clock()) > self._requested_time
        # The navigator did not get this observation: keep its scans for the next request.
        if not sent and new and self.time_rate.advances:
            self._unsent.keep(world.observation)

    def _take_answer(self, world: LiveWorld, answer: StepAnswer) -> None:
        """Use an answer; one that comes too late changes the view only."""
        driver, now = self._driver, self._clock()
        self._rides.add_log(answer.log)
        if answer.step_id < self._first_step_id:
            return  # from the previous world
        if answer.planning_context is not None:
            self._route_preview.set_planning_context(answer.planning_context)
        if answer.paused:
            return
        self.unstored_rows = answer.unstored
        if world.simulated:
            self.time_rate = self.time_rate.answered(now - self._navigator.requested_at, now)
        time = world.time(now)
        if time - self._requested_time <= MAX_ANSWER_LATENCY + 1e-6:
            self._watchdog = Watchdog.of(answer, now, time, self._requested_epoch)
        reason = answer.decision.reason
        faulty = reason in (KEPT if world.simulated else KEPT | INPUT_FAULTS)
        if faulty and driver_link.status(driver.link, now) == "ready":
            self.stop_until_confirmed(reason or Reason.CONFIRM)
        self.answered_mission = answer.mission_version
        self.view = self.view.updated(answer, driver.mission)
        current = answer.mission_version == driver.mission.version
        if answer.arrived and current and driver.mission.goal is not None and world.stands:
            self.arrived = True
            self._rides.end("arrived")
            self._send(Notice(code="arrived", text=driver.arrive()), None)

    def _select_command(self, now: float) -> float:
        """Set the decision at the wheels; returns the time since the last one, s."""
        watchdog = self._watchdog
        simulated = self.world is None or self.world.simulated
        passed = elapsed_time(self._commanded_at, now)
        elapsed = STEP * self.time_rate.advances if simulated else passed
        self._commanded_at = now
        if self.paused:
            self.command = stop(Reason.PAUSED)
            return elapsed
        no_decision = watchdog.decision is None and self._navigator.starts <= 1
        starting = self.awaits_world or no_decision
        if self._starting and not starting:
            self._driver.require_confirmation_of_trip()
        self._starting = starting
        hold_reason = held_by(self._driver.link, watchdog, now, starting=starting)
        if not starting and watchdog.silent(now, simulated=simulated):
            self.stop_until_confirmed(Reason.NAVIGATOR_TIMEOUT)
        time = self.world.time(now) if self.world is not None else 0.0
        selected = watchdog.select_command(time, hold_reason)
        newest = driver_link.current_heartbeat(self._driver.link, now).seq
        self._heartbeat_seq = watchdog.heartbeat_seq if hold_reason is None else newest
        if selected.reason is Reason.NAVIGATOR_TIMEOUT and self.command.twist.any():
            self.stops += 1
        limit = self._settings.limits.max_acceleration
        self.command = limit_acceleration(selected, self.command.twist, limit, elapsed)
        return elapsed

    def _advance(self, world: LiveWorld, elapsed: float) -> None:
        """Send the command to the wheels, and react to contacts."""
        if not self.time_rate.advances:
            return
        driver = self._driver
        length = world.apply(self.command)
        self.arrived &= not self.command.twist.any()
        self._rides.step(
            self.command,
            driver.mission,
            elapsed=elapsed,
            length=length,
            device=driver_link.current_heartbeat(driver.link, self._clock()).device,
        )
        touches = world.touches
        if touches and not self._touching:
            self.stop_until_confirmed(Reason.COLLISION)
            self._rides.end("collision")
            self._send(Notice(code="collision", text=Reason.COLLISION.sentence), None)
        self._touching = touches
        if driver.link.driver is None:
            self._rides.end("cancelled")

    def _send_state(self, world: LiveWorld | None, now: float, late: float) -> None:
        for message in self._sent.changes(self.view):
            self._send(message, None)
        step = StepStatus(
            seq=self.ticks,
            command=self.command,
            heartbeat_seq=self._heartbeat_seq,
            now=now,
            late=late,
            arrived=self.arrived,
            paused=self.paused,
            ride=self._rides.ride,
            starting_text=self.starting_text,
            not_ready=not_ready(
                *(self.command.reason, self._navigator, self._watchdog, now),
                mode=self._driver.mission.active_mode,
                simulated=world is None or world.simulated,
            ),
            can_plan=world is not None and self._navigator.ready and self._route_preview.ready,
            rate=self.time_rate.measured,
            unstored=self._unstored(),
        )
        if self.time_rate.notice:
            self._send(SLOW_NOTICE, None)
        self._send(state_message(world, self._driver, self.view, step), None)
