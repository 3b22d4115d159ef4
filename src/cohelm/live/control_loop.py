"""Thread of the control loop: deadlines, messages of pages, and supervision of the processes."""

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

from cohelm.errors import CohelmError
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.step_timing import STEP, StepTimer
from cohelm.live.control_cycle import ControlCycle
from cohelm.live.messages import Notice, Preparing, Send
from cohelm.live.preparation import Preparation
from cohelm.live.services import Services
from cohelm.live.sessions.audit import LogEvent
from cohelm.platforms import PlatformError
from cohelm.reasons import Reason

_log = logging.getLogger(__name__)
MAX_SLOW_CALLS = 64
"""Maximum number of slow calls in the queue; more are rejected."""
NO_PAUSE_BELOW = 0.002
"""Duration of a slow call up to which the next one follows at once, s."""
PAUSE_FACTOR = 9.0
"""Pause after a longer slow call, as a multiple of its duration: the loop keeps its deadlines."""
RETRY_PERIOD = 5.0
"""Time between two attempts to store what could not be stored, s."""
LOG_TIMEOUT = 1.0
"""Time for the navigator to deliver the log of the last ride when the drive is closed, s."""
Call = Callable[[], None]


class NotPossibleNow(CohelmError):
    """Request that the current state does not allow."""

    code = "not_now"


@dataclass(slots=True)
class DeadlineCounts:
    """Statistics of deadlines; a deadline is missed if a step ends after the next one is due."""

    missed: int = 0
    streak: int = 0
    """Number of missed deadlines without one that was kept, until now."""
    longest: int = 0
    """Maximum of ``streak``."""

    def add(self, *, missed: bool) -> None:
        """Count one more deadline."""
        self.missed += missed
        self.streak = self.streak + 1 if missed else 0
        self.longest = max(self.longest, self.streak)


class ControlLoop:
    """Control loop in a thread of its own; ``step_timing`` tells when its steps begin.

    Other threads may use :meth:`call`, :meth:`submit`, and read ``ready``, ``error``,
    ``deadlines`` and of the cycle ``state`` and ``moves``: each is replaced as a whole, so that a
    reader gets the old value or the new one. All else belongs to this thread.

    Args:
        cycle: One step of the loop.
        driver: Link and mission.
        services: Helpers of the loop.
        seed: Seed of the first world.
        cold: True if much is not compiled yet.
        early: False: a first start waits for all that is compiled; see ``Preparation``.
        send: Sends messages to pages.
        log_event: Adds entries to the audit log.
    """

    def __init__(
        self,
        cycle: ControlCycle,
        driver: DriverState,
        services: Services,
        *,
        seed: int,
        cold: bool,
        early: bool = True,
        send: Send,
        log_event: LogEvent,
    ) -> None:
        self.cycle, self._driver, self._services = cycle, driver, services
        self._navigator = services.navigator
        self._seed, self._send, self._log_event = seed, send, log_event
        self._calls: queue.SimpleQueue[Call] = queue.SimpleQueue()
        self._slow_calls: queue.Queue[Call] = queue.Queue(MAX_SLOW_CALLS)
        self._next_retry = time.monotonic() + RETRY_PERIOD
        self._next_slow_call = -math.inf
        """Time before which no slow call begins, s."""
        self._closing = threading.Event()
        self._timer = StepTimer(self._closing)
        self._usable, self._cold, self._early = False, cold, early
        self._preparation: Preparation | None = None
        """Compilation at a first start; None: everything is compiled."""
        self.deadlines = DeadlineCounts()
        self.error = ""
        """Reason why the chair cannot drive; empty if it can."""
        self.failure: CohelmError | None = None
        """Error of the first world, without which there is nothing to drive; None: no error."""
        self._thread = threading.Thread(target=self._run, name="control", daemon=True)

    @property
    def ready(self) -> bool:
        """True once the chair can drive, with a destination too."""
        preview = self._services.route_preview
        return self._steerable and self._preparation is None and preview.ready_or_failed

    @property
    def preparing(self) -> bool:
        """True while the code of routes is missing."""
        return self._preparation is not None

    @property
    def _steerable(self) -> bool:
        return self._navigator.ready and self.cycle.world is not None

    def start(self) -> None:
        """Start the thread."""
        if self._cold:
            _log.warning("compiling for this computer, once; the page shows how far it is")
            self._preparation = Preparation(early=self._early)
            self.cycle.preparing = Preparing(share=0.0)
        self._services.world_factory.start(self._seed, self._compiled)
        self._thread.start()

    def close(self) -> None:
        """End the thread and all processes."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()
        if self._preparation is not None:
            self._preparation.close()
        self._navigator.close()  # writes the rest of a log that was slow
        self._services.rides.navigator_lost()
        if self.cycle.world is not None:
            self.cycle.world.close()
        self._services.route_preview.close()

    def call(self, call: Call) -> None:
        """Queue a call for the control thread; it runs before anything else there."""
        self._calls.put(call)

    def submit(self, call: Call) -> bool:
        """Queue a slow call; returns False if the queue is full.

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
        self.cycle.await_world(on=True)
        self._services.world_factory.start(self._seed if seed is None else seed, lambda: True)

    def _compiled(self) -> bool:
        """True if what a chair without a destination needs is compiled."""
        return self._preparation is None or self._preparation.steerable

    def _prepare(self) -> None:
        """Follow the compilation, and let a navigator that has no code of routes load it."""
        if self._preparation is None:
            return
        self._preparation.poll()
        status = self._preparation.status
        self.cycle.preparing = Preparing(share=status.share, left=status.left)
        if status.done and self._navigator.ready:
            self.cycle.load_routes = not self._navigator.routes
            if self._navigator.routes:
                self._preparation.close()
                self._preparation = self.cycle.preparing = None

    def _run(self) -> None:
        due = time.monotonic()
        while not self._closing.is_set():
            begun = time.monotonic()
            try:
                self._step(due, begun)
            except PlatformError as error:
                self._fail(f"The chair is lost: {error}. Stopped.")
                return
            except Exception:  # whatever failed, the chair must stop and the pages must know
                self._fail()
                return
            if begun > due + STEP:  # no attempt to catch up with lost steps
                due = begun
            now = time.monotonic()
            if self._usable:
                self.deadlines.add(missed=now > due + STEP)
            world = self.cycle.world
            wait = world.wait if world is not None and not self.cycle.state.paused else None
            due = now if self.cycle.behind else self._timer.wait(due, wait)
        self._finish()

    def _step(self, due: float, now: float) -> None:
        self._supervise(now)
        self._run_calls()
        self._run_slow_calls()
        self.cycle.step(due, self._run_calls)

    def _fail(self, text: str = "The program has failed. Stopped.") -> None:
        """Fatal: command a stop in every step, and tell the pages, until the drive is closed."""
        _log.exception("the control loop has failed")
        self.error = "The control loop has failed; see the log."
        self._stop_after_failure()
        self.announce("loop_failed", text)
        while not self._closing.wait(STEP):
            self._run_calls()
            self._stop_after_failure()

    def _stop_after_failure(self) -> None:
        try:
            self.cycle.step_failed()
        except Exception:  # the world may have failed as well: try again in the next step
            _log.debug("no stop after the failure", exc_info=True)

    def _finish(self) -> None:
        """End the current ride and wait for its log, while the chair stands."""
        cycle, rides, end = self.cycle, self._services.rides, time.monotonic() + LOG_TIMEOUT
        cycle.await_world(on=True)
        cycle.pause(on=False)
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
            while (began := time.monotonic()) >= self._next_slow_call:
                self._guarded(self._slow_calls.get_nowait())
                spent = time.monotonic() - began
                if spent > NO_PAUSE_BELOW:
                    self._next_slow_call = began + (1.0 + PAUSE_FACTOR) * spent

    def _guarded(self, call: Call) -> None:
        """Run a call; a fault in it does not end the ride."""
        try:
            call()
        except Exception:  # a faulty message of one page must not end the drive
            _log.exception("a message from a page could not be processed")

    def _supervise(self, now: float) -> None:
        """Take over processes that are ready, replace lost ones, and install new worlds."""
        self._prepare()
        routes = self._preparation is None or self._preparation.status.done
        if self._compiled() and self._navigator.supervise(now, routes=routes):
            self.cycle.navigator_restarted()
            if self._navigator.starts > 1:
                self._driver.stop_until_confirmed(Reason.NAVIGATOR_TIMEOUT)
                self.announce("navigator_ready", "The navigator is ready again.")
        self._handle_lost_navigator()
        if now >= self._next_retry:
            self._next_retry = now + RETRY_PERIOD
            self._services.rides.retry()
        if routes:
            self._services.route_preview.start()
        self._services.route_preview.poll()
        self._install_world()
        previewing = self._services.route_preview.ready_or_failed or not routes
        if self._steerable and previewing and not self._usable:
            self._usable = True
            gc.collect()
            gc.freeze()  # objects that exist now stay: the collector need not visit them again
            self.cycle.navigator_restarted()

    def _handle_lost_navigator(self) -> None:
        lost, self._navigator.lost = self._navigator.lost, ""
        if not lost:
            return
        self._services.rides.navigator_lost()
        self._driver.stop_until_confirmed(Reason.NAVIGATOR_TIMEOUT)
        self._log_event("chair", "navigator_lost", reason=lost)
        if self._navigator.gave_up:
            self.error = "The navigator does not start; see the log."
            self.announce("navigator_failed", "The navigator does not start. Stopped.")
            return
        text = "The navigator has failed and restarts."
        unanswered = self._navigator.unanswered
        # A mission that it never answered would bring down its successor as well.
        answered = self.cycle.state.answered_mission
        if unanswered is not None and unanswered.mission_version != answered:
            self._driver.clear_mission()
            text = "The navigator has failed. It restarts without destination and wishes."
        self.announce("navigator_lost", text)

    def _install_world(self) -> None:
        try:
            world = self._services.world_factory.finished()
        except CohelmError as error:
            self.cycle.await_world(on=False)
            first = self.cycle.world is None
            # The first one ends the drive, whose owner gets the error.
            _log.log(logging.INFO if first else logging.ERROR, "no world: %s", error)
            if first:
                self.error, self.failure = str(error), error
            else:  # the old world goes on, and the stick may have been held meanwhile
                self._driver.require_centring()
            self.announce(error.code, str(error))
            return
        if world is None:
            return
        again = self.cycle.world is not None
        if self.cycle.world is not None:
            self.cycle.world.close()
        self.cycle.enter(world)
        self._seed = seed = world.ride_setup.seed
        if again:
            self._log_event("chair", "simulation_restarted", seed=seed)
            self.announce("simulation_restarted", f"The simulation has restarted with seed {seed}.")

    def announce(self, code: str, text: str) -> None:
        """Tell all pages of an event."""
        self._send(Notice(code=code, text=text), None)
