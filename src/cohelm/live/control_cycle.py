"""Control cycle at 20 Hz: from the observation to the wheels, whatever fails.

t       commands of pages; the valid heartbeat goes into the observation, and that to the navigator
…       its answer, awaited as long as the step allows
t + c   decision for the wheels: the answer, or a stop by link, watchdog or another hold; pages get
        the state; the world advances one step
t + T   next step
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cohelm.live.control import link
from cohelm.live.control.ipc import StepAnswer, StepRequest
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.mission import request_of
from cohelm.live.control.watchdog import CONFIRM_AFTER, PATIENCE, Watchdog, limit_acceleration
from cohelm.live.control.world_factory import LiveWorld
from cohelm.live.messages import Notice
from cohelm.live.page.commands import Commands, Send
from cohelm.live.page.state_messages import PageView, state_message
from cohelm.live.services import Services
from cohelm.messages import Observation, PointCloud, Request, RiderCommand, RiderProfile, Scan
from cohelm.reasons import Reason
from cohelm.safety import stop
from cohelm.simulation import is_standing

STEP = 0.05
"""Control period, s."""
ANSWER_TIME = 0.036
"""Part of a step in which an answer is awaited, s; the rest is for the world."""
_MAX_UNSEEN = 8
"""Maximum number of scans kept for a navigator that is late."""


class ControlCycle:
    """Chair in its world with the navigator; belongs to one thread.

    Args:
        commands: Link and mission.
        settings: Limits and rider's settings.
        profile: Profile of the scenario's rider.
        services: Helpers.
        send: Sends messages to pages.
        clock: Monotonic clock, s.
    """

    def __init__(
        self,
        commands: Commands,
        settings: ActiveSettings,
        profile: RiderProfile,
        services: Services,
        *,
        send: Send,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._commands, self._settings, self._profile = commands, settings, profile
        self._navigator, self._rides = services.navigator, services.rides
        self._route_preview = services.route_preview
        self._send, self._clock = send, clock
        self.world: LiveWorld | None = None
        self._starting = True
        self.paused = False
        self.waits = False
        """True while another world is built; until then the chair stands."""
        self._restart, self._since = False, 0
        self._watchdog = Watchdog()
        self.view = PageView()
        self._sent_route = -1
        self.order = stop(Reason.STARTING)
        """Decision at the wheels."""
        self.starting_text = ""
        """Additional text while the chair starts."""
        self._heartbeat, self._epoch = -1, 0
        self._scans: tuple[Scan, ...] = ()
        self._clouds: tuple[PointCloud, ...] = ()
        self._touching = self.arrived = False
        self.ticks = 0
        self.answered_mission = -1
        """``Mission.version`` of the navigator's last answer; −1: none since it started."""
        self.stops = 0
        """Number of stops by the watchdog."""

    @property
    def moves(self) -> bool:
        """True where the chair moves, or has a command to move."""
        if self.world is None:
            return False
        truth = self.world.simulation.truth
        return bool(self.order.twist.any()) or not bool(is_standing(truth.twist))

    def enter(self, world: LiveWorld) -> None:
        """Put the chair into another world, where it stands without a destination.

        A destination chosen before there was a world is kept.
        """
        restarted = self.world is not None
        self.world, self.paused, self.waits = world, False, False
        self._restart, self._since = True, self.ticks
        version = self.view.route_version + 1
        self._watchdog, self.view = Watchdog(), PageView(route_version=version)
        self._scans, self._clouds = (), ()
        self._touching = self.arrived = False
        self.order = stop(Reason.STARTING)
        commands = self._commands
        if restarted:
            commands.mission = commands.mission.with_goal(None).without_wish(None, every=True)
        commands.link = link.require_centring(commands.link)
        self._rides.enter(world.ride_setup)

    def pause(self, *, on: bool) -> None:
        """Pause the simulation, or resume it; then the stick must be centred first."""
        if self.paused and not on:
            self._commands.link = link.require_centring(self._commands.link)
            self._watchdog = replace(self._watchdog, at=self._clock())
        self.paused = on

    def navigator_restarted(self) -> None:
        """Forget the old navigator's decisions: the new one has no memory."""
        self._restart, self._watchdog, self.answered_mission = True, Watchdog(), -1

    def hold(self, cause: Reason) -> None:
        """Stop until the driver confirms."""
        self._commands.link = link.stop_until_confirmed(self._commands.link, cause)

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
            # A step that is already lost gets its full time.
            until = due + ANSWER_TIME + (late if late >= STEP else 0.0)
            self._request_step(world, late)
            self._await_answer(world, until, late)
            run_calls()
        if world is not self.world:
            return  # a command has replaced the world
        now = self._clock()
        self._decide(now)
        self._send_state(world, now, late)
        if world is not None and not self.paused:
            self._advance(world)
        self.ticks += 1

    def _request_step(self, world: LiveWorld, late: float) -> None:
        """Send the newest observation if the navigator is free."""
        if not self._navigator.free:
            return
        now, driver_link = self._clock(), self._commands.link
        observation = world.simulation.observe()
        ready = link.status(driver_link, now) == "ready"
        marks = self._rides.take_marks()
        observation = replace(
            observation,
            scans=(*self._scans, *observation.scans),
            clouds=(*self._clouds, *observation.clouds),
            rider=self._rider_command(observation, now) if ready else None,
            late=late,
        )
        min_distance = self._settings.limits.min_distance
        step = StepRequest(
            number=self.ticks,
            mission=self._commands.mission.version,
            observation=observation,
            request=self._request(moves=ready),
            truth=world.simulation.truth,
            heartbeat=link.current_heartbeat(driver_link, now)[0] if ready else -1,
            extra_clearance=max(min_distance - self._profile.social_distance, 0.0),
            restart=self._restart,
            begin=marks.begin,
            end=marks.end,
            planning_context=self._route_preview.needs_context,
        )
        self._restart = False
        self._scans, self._clouds = (), ()
        self._epoch = driver_link.epoch
        self._navigator.request(step, now)

    def _step_paused(self, world: LiveWorld) -> None:
        """Take a late answer, and request the planning context of a route preview."""
        now = self._clock()
        answer = self._navigator.answer(0.0, now)
        if answer is not None:
            self._take_answer(world, answer)
        if not (self._route_preview.needs_context and self._navigator.free):
            return
        step = StepRequest(
            number=self.ticks,
            mission=self._commands.mission.version,
            observation=world.simulation.observe(),
            request=self._request(moves=False),
            truth=world.simulation.truth,
            heartbeat=-1,
            paused=True,
            planning_context=True,
        )
        self._navigator.request(step, now)

    def _request(self, *, moves: bool) -> Request:
        limits, rider = self._settings.limits, self._settings.rider
        return request_of(self._commands.mission, self._profile, limits, rider, moves=moves)

    def _rider_command(self, observation: Observation, now: float) -> RiderCommand:
        """Return the rider's stick with the heartbeat in the time of the simulation."""
        age = max(now - self._commands.link.at, 0.0)
        stick = np.array(link.deflection(self._commands.link, now))
        return RiderCommand(heartbeat=observation.time - age, deflection=stick)

    def _await_answer(self, world: LiveWorld, until: float, late: float) -> None:
        """Take answers until ``until``, s, or until that of this step has come."""
        while self._navigator.pending is not None:
            now = self._clock()
            answer = self._navigator.answer(max(until - now, 0.0), now)
            if answer is None:
                break
            self._take_answer(world, answer)
            if answer.number == self.ticks or self._clock() >= until:
                break
            self._request_step(world, late)
        pending = self._navigator.pending
        if pending is not None and pending.number == self.ticks:
            return
        # The navigator did not get this observation: keep its scans for the next request.
        if pending is not None or not self._navigator.ready:
            observation = world.simulation.observe()
            self._scans = (*self._scans, *observation.scans)[-_MAX_UNSEEN:]
            self._clouds = (*self._clouds, *observation.clouds)[-_MAX_UNSEEN:]

    def _take_answer(self, world: LiveWorld, answer: StepAnswer) -> None:
        """Use an answer; one that comes too late changes the view only."""
        commands, now = self._commands, self._clock()
        self._rides.add_log(answer.log)
        if answer.number < self._since:
            return  # from the previous world
        if answer.planning_context is not None:
            self._route_preview.set_planning_context(answer.planning_context)
        if answer.paused:
            return
        if now - self._navigator.requested_at <= PATIENCE:
            self._watchdog = self._watchdog.updated(
                answer.decision, answer.heartbeat, now, self._epoch
            )
        self.answered_mission = answer.mission
        self.view = self.view.updated(answer, commands.mission)
        mission = commands.mission
        current = answer.mission == mission.version and mission.goal is not None
        if answer.arrived and current and bool(is_standing(world.simulation.truth.twist)):
            self._arrive()

    def _decide(self, now: float) -> None:
        """Set the decision at the wheels."""
        watchdog = self._watchdog
        if self.paused:
            self.order = stop(Reason.PAUSED)
            return
        no_decision = watchdog.decision is None and self._navigator.starts <= 1
        self._set_starting(self.waits or no_decision)
        hold = link.hold_reason(self._commands.link, now)
        if hold is None and watchdog.epoch != self._commands.link.epoch:
            hold = Reason.RELEASE_STICK  # decided before the last stop
        if self._starting:
            hold = Reason.STARTING
        elif watchdog.decision is None or now - watchdog.at > CONFIRM_AFTER:
            self.hold(Reason.NAVIGATOR_TIMEOUT)
        order = watchdog.order(now, hold)
        driver_link = self._commands.link
        self._heartbeat = (
            watchdog.heartbeat if hold is None else link.current_heartbeat(driver_link, now)[0]
        )
        if order.reason is Reason.NAVIGATOR_TIMEOUT and self.order.twist.any():
            self.stops += 1
        limit = self._settings.limits.max_acceleration
        self.order = limit_acceleration(order, self.order.twist, limit, STEP)

    def _set_starting(self, starting: bool) -> None:
        """Require confirmation where a destination was chosen before the chair was ready."""
        commands = self._commands
        if self._starting and not starting and commands.mission.under_way:
            commands.link = link.require_confirmation(commands.link)
        self._starting = starting

    def _advance(self, world: LiveWorld) -> None:
        """Advance the world one step, and react to contacts."""
        commands, simulation = self._commands, world.simulation
        before = simulation.truth
        simulation.advance(self.order)
        after = simulation.truth
        self.arrived &= not self.order.twist.any()
        self._rides.step(
            self.order,
            commands.mission,
            length=float(np.hypot(*(after.pose[:2] - before.pose[:2]))),
            device=link.current_heartbeat(commands.link, self._clock())[1],
        )
        touches = bool(after.hit_moving.any()) or after.hit_wall
        if touches and not self._touching:
            self.hold(Reason.COLLISION)
            self._rides.end("collision")
            self._send(Notice(code="collision", text=Reason.COLLISION.sentence), None)
        self._touching = touches
        if commands.link.driver is None:
            self._rides.end("cancelled")

    def _arrive(self) -> None:
        commands = self._commands
        goal = commands.mission.goal
        text = f"You have arrived: {goal.name}." if goal and goal.name else Reason.ARRIVED.sentence
        commands.mission = commands.mission.with_goal(None)
        commands.link = link.require_centring(commands.link)
        self.arrived = True
        self._rides.end("arrived")
        self._send(Notice(code="arrived", text=text), None)

    def _send_state(self, world: LiveWorld | None, now: float, late: float) -> None:
        if self.view.route_version != self._sent_route:
            self._sent_route = self.view.route_version
            self._send(self.view.route_update(), None)
        state = state_message(
            world,
            self._commands,
            self.view,
            self.order,
            starting_text=self.starting_text,
            now=now,
            seq=self.ticks,
            heartbeat=self._heartbeat,
            lateness=round(1000.0 * late, 1),
            clock=round(now, 4),
            arrived=self.arrived,
            paused=self.paused,
            ride=self._rides.ride,
        )
        self._send(state, None)
