"""Thread of the control loop: absolute deadlines, commands in between, supervision of processes."""

from __future__ import annotations

import contextlib
import gc
import logging
import math
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cohelm.errors import CohelmError
from cohelm.live.control_cycle import STEP, ControlCycle
from cohelm.live.messages import AddWish, ChangeSimulation, Notice
from cohelm.live.page.commands import Commands, LogEvent, Send
from cohelm.live.page.route_preview import RoutePreview
from cohelm.live.ride_sessions import RideSessions
from cohelm.live.services import Services
from cohelm.reasons import Reason
from cohelm.safety import stop

_log = logging.getLogger(__name__)
FIRST_TIME = "The first time this takes a minute or two."
MAX_WAITING = 64
"""Maximum number of slow calls in the queue; more are rejected."""
QUICK = 0.002
"""After a slow call of longer duration, s, the next one waits …"""
PAUSE_FACTOR = 9.0
"""… for this multiple of the duration, so that the loop keeps its deadlines."""
LOG_TIMEOUT = 1.0
"""Time for the navigator to deliver the log of the last ride when the program ends, s."""
Call = Callable[[Commands], None]


class NotPossibleNow(CohelmError):
    """Request that the present state does not allow."""

    code = "not_now"


@dataclass(slots=True)
class DeadlineCounts:
    """Statistics of deadlines."""

    missed: int = 0
    streak: int = 0
    longest: int = 0

    def add(self, *, missed: bool) -> None:
        """Count one more deadline."""
        self.missed += missed
        self.streak = self.streak + 1 if missed else 0
        self.longest = max(self.longest, self.streak)


class LiveLoop:
    """Control loop at 20 Hz.

    Args:
        cycle, commands: Used by this thread only, once it runs.
        services: Helpers of the loop.
        seed: Seed of the first world.
        cold: True where nothing is compiled yet.
        send, log_event: Message listener and audit log.
    """

    def __init__(
        self,
        cycle: ControlCycle,
        commands: Commands,
        services: Services,
        *,
        seed: int,
        cold: bool,
        send: Send,
        log_event: LogEvent,
    ) -> None:
        self.cycle, self._commands, self._services = cycle, commands, services
        self._navigator = services.navigator
        self._seed, self._send, self._log_event = seed, send, log_event
        self._calls: queue.SimpleQueue[Call] = queue.SimpleQueue()
        self._slow_calls: queue.Queue[Call] = queue.Queue(MAX_WAITING)
        self._slow_calls_wait_until = -math.inf
        self._closing = threading.Event()
        self._ready, self._cold = False, cold
        self.deadlines = DeadlineCounts()
        self.error = ""
        """Reason why the chair will never drive; empty where it may."""
        self._thread = threading.Thread(target=self._run, name="control", daemon=True)

    @property
    def ready(self) -> bool:
        """True once the chair can drive."""
        preview = self._services.route_preview
        return self._navigator.ready and preview.settled and self.cycle.world is not None

    def start(self) -> None:
        """Start the thread."""
        if self._cold:
            _log.warning("compiling for this machine, once; it takes a minute or two")
        self.cycle.starting_text = FIRST_TIME if self._cold else ""
        self._services.world_factory.start(self._seed, self._compiled)
        self._thread.start()

    def close(self) -> None:
        """End the thread and all processes."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()
        self._services.rides.navigator_lost()
        self._navigator.close()
        self._services.route_preview.close()

    def call(self, call: Call) -> None:
        """Queue a call for the control thread; it runs before anything else there."""
        self._calls.put(call)

    def submit(self, call: Call) -> bool:
        """Queue a slow call; returns False where the queue is full.

        It never delays STOP, a heartbeat or a take-over.
        """
        try:
            self._slow_calls.put_nowait(call)
        except queue.Full:
            return False
        return True

    def restart_world(self, seed: int | None) -> None:
        """Start to build another world; None keeps the seed.

        Raises:
            NotPossibleNow: A world is being built already.
        """
        if self._services.world_factory.busy:
            raise NotPossibleNow("The simulation is already restarting.")
        self._seed = self._seed if seed is None else seed
        self.cycle.waits = True
        self._services.world_factory.start(self._seed, lambda: True)

    def _compiled(self) -> bool:
        """Let one process compile at a time: two of them could corrupt the cache."""
        return self._navigator.ready or not self._cold

    def _run(self) -> None:
        due = time.monotonic()
        while not self._closing.is_set():
            begun = time.monotonic()
            try:
                self._supervise(begun)
                self._run_calls()
                self._run_slow_calls()
                self.cycle.step(due, self._run_calls)
            except Exception:  # any fault must leave a chair that stands, and a message
                _log.exception("the control loop has failed")
                self.cycle.order = stop(Reason.NAVIGATOR_TIMEOUT)
                self.error = "the control loop has failed; see the log"
                self._announce("loop_failed", "The program has failed. Stopped.")
                return
            if begun > due + STEP:  # no attempt to catch up with lost steps
                due = begun
            due += STEP
            now = time.monotonic()
            if self._ready:
                self.deadlines.add(missed=now > due)
            self._closing.wait(max(due - now, 0.0))
        self._finish()

    def _finish(self) -> None:
        """End the present ride and wait for its log, while the chair stands."""
        cycle, rides, end = self.cycle, self._services.rides, time.monotonic() + LOG_TIMEOUT
        cycle.waits, cycle.paused = True, False
        try:
            rides.end("cancelled")
            while rides.waits_for_log and self._navigator.ready and time.monotonic() < end:
                cycle.step(time.monotonic(), lambda: None)
        except Exception:  # the processes must be closed whatever happens here
            _log.exception("the last ride could not be ended")

    def _run_calls(self) -> None:
        """Run all queued calls in their order."""
        with contextlib.suppress(queue.Empty):
            while True:
                self._guarded(self._calls.get_nowait())

    def _run_slow_calls(self) -> None:
        """Run as many slow calls as leave the loop its time."""
        with contextlib.suppress(queue.Empty):
            while (began := time.monotonic()) >= self._slow_calls_wait_until:
                self._guarded(self._slow_calls.get_nowait())
                spent = time.monotonic() - began
                if spent > QUICK:
                    self._slow_calls_wait_until = began + (1.0 + PAUSE_FACTOR) * spent

    def _guarded(self, call: Call) -> None:
        """Run a call; a fault in it does not end the ride."""
        try:
            call(self._commands)
        except Exception:  # one page's command must not stop the chair of another
            _log.exception("a command from a page has failed")

    def _supervise(self, now: float) -> None:
        """Take over processes that are ready, replace lost ones, and install new worlds."""
        if self._navigator.supervise(now):
            self.cycle.navigator_restarted()
            if self._navigator.starts > 1:
                self.cycle.hold(Reason.NAVIGATOR_TIMEOUT)
                self._announce("navigator_ready", "The navigator is ready again.")
        self._handle_lost_navigator()
        if self._compiled():
            self._services.route_preview.start()
        self._services.route_preview.poll()
        self._install_world()
        if self.ready and not self._ready:
            self._ready = True
            gc.collect()
            gc.freeze()  # objects that exist now stay: the collector need not visit them again
            self.cycle.navigator_restarted()

    def _handle_lost_navigator(self) -> None:
        lost, self._navigator.lost = self._navigator.lost, ""
        if not lost:
            return
        self._services.rides.navigator_lost()
        self.cycle.hold(Reason.NAVIGATOR_TIMEOUT)
        self._log_event("chair", "navigator_lost", reason=lost)
        if self._navigator.gave_up:
            self.error = "the navigator does not start; see the log"
            self._announce("navigator_failed", "The navigator does not start. Stopped.")
            return
        text = "The navigator has failed and restarts."
        unanswered, commands = self._navigator.unanswered, self._commands
        # A mission that it never answered would bring down its successor as well.
        if unanswered is not None and unanswered.mission != self.cycle.answered_mission:
            commands.mission = commands.mission.with_goal(None).without_wish(None, every=True)
            text = "The navigator has failed. It restarts without destination and wishes."
        self._announce("navigator_lost", text)

    def _install_world(self) -> None:
        try:
            world = self._services.world_factory.finished()
        except CohelmError as error:
            _log.error("no world: %s", error)
            self.cycle.waits = False
            self.error = "" if self.cycle.world is not None else str(error)
            self._announce(error.code, str(error))
            return
        if world is None:
            return
        again = self.cycle.world is not None
        self.cycle.enter(world)
        if again:
            seed = world.ride_setup.seed
            self._log_event("chair", "simulation_restarted", seed=seed)
            self._announce(
                "simulation_restarted", f"The simulation has restarted with seed {seed}."
            )

    def _announce(self, code: str, text: str) -> None:
        self._send(Notice(code=code, text=text), None)


class LiveCommandEffects:
    """Effects of commands on the loop; see ``commands.CommandEffects``.

    Args:
        rides: Stores ratings.
    """

    def __init__(self, rides: RideSessions) -> None:
        self._rides = rides
        self.loop: LiveLoop
        self.route_preview: RoutePreview

    def change_simulation(self, command: ChangeSimulation) -> None:
        """Change the simulated world.

        Raises:
            CohelmError: The change is not possible.
        """
        cycle = self.loop.cycle
        if command.action == "restart":
            self.loop.restart_world(command.seed)
            return
        if cycle.world is None:
            raise NotPossibleNow(Reason.STARTING.sentence)
        if command.action == "pause":
            cycle.pause(on=command.on)
            return
        route = cycle.view.route
        points = np.array(route.points if route is not None else ()).reshape(-1, 2)
        cycle.world.change(command, points)

    def preview(self, client: str, wish: AddWish) -> None:
        """Request the cost of a wish; the answer comes later."""
        self.route_preview.request(client, wish)

    def rate(self, ride: str, rating: int) -> None:
        """Store a rating.

        Raises:
            StoreError: There is no such ride.
        """
        self._rides.rate(ride, rating)
