"""Live ride as a server sees it: commands go in, messages come out.

    drive = Drive(DriveSetup(scenario=load_scenario("hospital")))
    drive.listen(lambda message, client: ...)    # called in the control thread: do not wait there
    drive.start()                                # returns at once; ChairState.reason: starting
    drive.connect("a", "driver")                 # sends Welcome before it returns
    drive.receive("a", Heartbeat(seq=0, sent=0.0), time.monotonic())
    drive.close()

No call waits for the control loop, and every call may come from any thread.
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
import weakref
from pathlib import Path
from typing import Literal

from cohelm import kernel_cache
from cohelm.arrays import replace, value
from cohelm.config import Model
from cohelm.errors import CohelmError
from cohelm.live.commands import HANDLERS, CommandHandler, NextStorey
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.ipc import ProcessSetup
from cohelm.live.control.limits import OVER_EDGES, ActiveSettings, ChairMoves, LimitsLoosened
from cohelm.live.control.navigator_client import NavigatorClient
from cohelm.live.control.world_factory import WorldFactory
from cohelm.live.control_cycle import ControlCycle
from cohelm.live.control_loop import ControlLoop
from cohelm.live.floor_model import DriveStorey, floor_model
from cohelm.live.messages import (
    Echo,
    FromPage,
    Limits,
    Notice,
    Pace,
    Rejected,
    RiderSettings,
    Role,
    SceneInfo,
    Send,
    SettingsChanged,
    ToPage,
    Welcome,
)
from cohelm.live.page.route_preview import RoutePreview
from cohelm.live.ride_tracker import RideTracker
from cohelm.live.rider_choice import RiderChoice
from cohelm.live.services import Services
from cohelm.live.sessions.audit import AuditLog
from cohelm.live.sessions.files import lock_folder
from cohelm.live.sessions.habits import with_habits
from cohelm.live.sessions.map_changes import remembered_changes
from cohelm.live.sessions.response import stored_response, with_response
from cohelm.live.sessions.store import SessionStore
from cohelm.maps import OccupancyGrid
from cohelm.messages import Mode
from cohelm.scenarios import Scenario


class DriveHealth(Model):
    """Condition of the control loop and its processes."""

    status: Literal["ok", "degraded", "failed"]
    """``degraded``: something cannot be stored; ``failed``: the chair cannot drive any more."""
    problem: str
    """Reason of both; empty with ``ok``."""
    ready: bool
    """True if the chair can drive."""
    ticks: int
    """Control steps so far."""
    missed: int
    """Steps that overran their period, since the chair was ready."""
    longest_streak: int
    """Maximum number of consecutive missed steps."""
    stops: int
    """Stops by the watchdog."""
    restarts: int
    """Restarts of the navigator."""
    rate: float = 1.0
    """Speed of simulated time, 1: real time."""


@value
class DriveSetup:
    """Scenario of a live ride, and the files to keep."""

    scenario: Scenario
    """Floor, people, chair and parts; goal and wishes are ignored, since the rider sets them."""
    seed: int = 0
    """Random seed of the world, ≥ 0."""
    folder: Path | None = None
    """Folder for sessions, limits and the audit log; None: nothing is kept."""
    record: Path | None = None
    """MCAP file that gets every tick; must not exist."""
    limits: Limits | None = None
    """Initial limits; None: the stored ones, else those of the robot."""
    rider: RiderSettings | None = None
    """Initial rider's settings; None: the stored ones, else those of the profile."""
    mode: Mode | None = None
    """Initial mode; None: that of the rider who rode last, else shared."""
    pace: Pace | None = None
    """Initial pace, as for ``mode``."""
    storey: str = ""
    """Name of the storey on whose map the chair drives; empty: it is no storey of a building."""
    storeys: tuple[DriveStorey, ...] = ()
    """All storeys of the building."""


_NEARLY_ALL = 0.9
"""Share of the kernels from which a start is no first start."""


class Drive:
    """Chair in simulation that a person drives live.

    Args:
        setup: Scenario, seed and files.

    Raises:
        CohelmError: The scenario refers to something missing, or the folder cannot be written or
            is in use by another drive: limits of one would not hold in the other.
    """

    def __init__(self, setup: DriveSetup) -> None:
        # What a navigator lacks of a nearly complete cache it compiles itself.
        cold = kernel_cache.share() < _NEARLY_ALL and kernel_cache.place().lasts
        model = floor_model(setup.scenario, setup.seed, setup.storey, setup.storeys)
        self._scene, self._png, self.solids = model.scene, model.png, model.solids
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        if setup.folder is None:
            self._temporary = tempfile.TemporaryDirectory(prefix="cohelm-")
        folder = setup.folder or Path(self._temporary.name if self._temporary else "")
        self._release = weakref.finalize(self, os.close, lock_folder(folder))
        self.audit = AuditLog(folder)
        """Audit log of who drove and who changed what."""
        self.sessions = SessionStore(folder)
        """Stored sessions and rides."""
        profile = with_response(setup.scenario.profile, stored_response(self.sessions.database))
        self._settings = ActiveSettings(
            setup.folder, model.robot, profile, limits=setup.limits, rider=setup.rider
        )
        self._listeners: tuple[Send, ...] = ()
        self._announcing = threading.Lock()
        self._services = services = self._make_services(setup, folder, model.grid)
        self._driver = driver = DriverState()
        self._resumed, log_event = (setup.mode, setup.pace), self.audit.log_event
        cycle = ControlCycle(
            driver,
            self._settings,
            profile,
            services,
            send=self._send,
            unstored=lambda: self.unstored,
        )
        self._loop = ControlLoop(
            cycle,
            driver,
            services,
            seed=setup.seed,
            cold=cold,
            early=self._scene.simulation,
            send=self._send,
            log_event=log_event,
        )
        self._commands = CommandHandler(
            driver,
            model,
            self._settings,
            self._loop,
            services,
            send=self._send,
            log_event=log_event,
        )
        self.riders = RiderChoice(
            self.sessions,
            self._settings,
            driver,
            services.rides,
            self._loop,
            log_event=log_event,
            announce=self._announce_settings,
            modes=model.scene.modes,
        )
        """Riders, their presets and their progress."""
        self._closed = False

    def _make_services(self, setup: DriveSetup, folder: Path, grid: OccupancyGrid) -> Services:
        """Make what runs beside the control loop; no process is started yet."""
        # Only the navigator infers; the world stays the same whatever the rider's habits.
        process_setup = ProcessSetup(
            scenario=with_habits(setup.scenario, self.sessions.list()),
            seed=setup.seed,
            folder=folder,
            record=setup.record,
            changes=remembered_changes(self.sessions.database, grid),
        )
        return Services(
            navigator=NavigatorClient(process_setup),
            route_preview=RoutePreview(process_setup, self._send),
            world_factory=WorldFactory(setup.scenario),
            rides=RideTracker(self.sessions, self._settings, self._send),
        )

    def start(self) -> None:
        """Start the ride and return at once.

        Until its kernels are compiled and warm the chair stands and ``ChairState.reason`` says so;
        ``ChairState.preparing`` tells how far a first start is.
        """
        scene = self._scene
        self.audit.log_event("chair", "drive_started", scene=scene.name, seed=scene.seed)
        self.riders.restore()
        self._loop.call(self._resume)
        self._loop.start()

    def _resume(self) -> None:
        """Put the initial mode and pace into force."""
        mode, pace, driver = *self._resumed, self._driver
        driver.mission = replace(
            driver.mission, mode=mode or driver.mission.mode, pace=pace or driver.mission.pace
        )

    def close(self) -> None:
        """Stop the chair, end the ride and all processes; may be called twice."""
        if self._closed:
            return
        self._closed = True
        self._loop.close()
        self.audit.log_event("chair", "drive_closed")
        self.sessions.close()
        self.audit.close()
        self._release()
        if self._temporary is not None:
            self._temporary.cleanup()

    @property
    def next_storey(self) -> NextStorey | None:
        """Storey on which a page says that the chair is now: this drive is to end; else None."""
        return self._commands.next_storey

    def scene(self) -> SceneInfo:
        """Return the facts that stay the same while driving; known before :meth:`start`."""
        return self._scene

    def floor_png(self) -> bytes:
        """Return the map as grey PNG: 0 occupied, 128 unknown, 255 free; first row at the top."""
        return self._png

    def listen(self, callback: Send) -> None:
        """Pass every message from now on to ``callback``.

        It is called in the control thread and, for answers that do not need the loop (Welcome,
        RouteUpdate, MapDifferences, EdgeCells, SettingsChanged, Echo), in the caller's own thread
        before the call returns.
        It must neither wait nor raise.
        """
        self._listeners = (*self._listeners, callback)

    def connect(self, client: str, role: Role) -> None:
        """Add a page; it gets Welcome, route, map differences and edges before this returns.

        Args:
            client: Unique name of the connection, never used again.
            role: Role of the signed-in person.
        """
        welcome = Welcome(
            client=client, role=role, scene=self._scene, limits=self.limits, rider=self.rider
        )
        self._send(welcome, client)
        view = self._loop.cycle.state.view
        self._send(view.route, client)
        if view.differences.found:
            self._send(view.differences, client)
        if view.edges.runs:
            self._send(view.edges, client)
        self._loop.call(lambda: self._commands.connect(client, role))

    def disconnect(self, client: str) -> None:
        """Remove a page; if it drove, the chair stops."""
        self._loop.call(lambda: self._commands.disconnect(client))

    def receive(self, client: str, message: FromPage, at: float | None = None) -> None:
        """Take a message from a page; answers come through the listeners.

        Args:
            client: Name of a connected page.
            message: Already validated.
            at: Arrival time by ``time.monotonic()``, s; None: now.
        """
        if isinstance(message, Echo):
            self._send(message, client)
            return
        arrival = time.monotonic() if at is None else at

        def process() -> None:
            self._commands.receive(client, message, arrival)

        if not HANDLERS[type(message)].slow:
            self._loop.call(process)
        elif not self._loop.submit(process):
            text = "Too many requests at once."
            id_ = getattr(message, "id", 0)
            self._send(Rejected(id=id_, code="too_many_requests", text=text), client)

    @property
    def limits(self) -> Limits:
        """Limits in force."""
        return self._settings.limits

    def set_limits(self, limits: Limits, actor: str) -> None:
        """Change the limits; all clients get ``SettingsChanged``, the audit log an entry.

        Args:
            limits: New limits, bounded by the robot's.
            actor: Name for the audit log.

        Raises:
            LimitsLoosened: A limit would become looser while the chair moves.
            StoreError: Looser limits cannot be stored; the previous ones stay in force. Tighter
                ones take effect all the same, and :attr:`unstored` says so.
        """
        try:
            before = self._settings.set_limits(limits, lambda: not self._loop.cycle.moves)
        except LimitsLoosened:
            self.audit.log_event(actor, "limits_rejected", requested=limits.model_dump())
            raise
        after = self.limits.model_dump()
        self.audit.log_event(actor, "limits_changed", before=before.model_dump(), after=after)
        self._announce_settings()

    def allow_edges(self, actor: str, now: float) -> None:
        """Let the chair creep over edges of the floor for ``OVER_EDGES``, and log it.

        Args:
            actor: Name for the audit log.
            now: s of the control loop's clock.

        Raises:
            ChairMoves: Nothing was changed.
        """
        if self._loop.cycle.moves:
            raise ChairMoves("Edges can be allowed only while the chair stands.")
        self._settings.over_edges_until = now + OVER_EDGES
        self.audit.log_event(actor, "edges_allowed", seconds=OVER_EDGES)
        text = (
            f"Edges of the floor are allowed for {OVER_EDGES:.0f} s. The chair does not avoid them."
        )
        self._send(Notice(code="edges_allowed", text=text), None)

    @property
    def rider(self) -> RiderSettings:
        """Rider's settings in force."""
        return self._settings.rider

    def set_rider(self, rider: RiderSettings, actor: str) -> None:
        """Change the rider's settings; all clients and the audit log are informed.

        Raises:
            StoreError: The settings cannot be stored; the previous ones stay in force.
        """
        before = self._settings.set_rider(rider).model_dump()
        after = rider.model_dump()
        self.audit.log_event(actor, "rider_settings_changed", before=before, after=after)
        self._announce_settings()

    @property
    def health(self) -> DriveHealth:
        """Condition of the control loop and its processes."""
        loop, cycle, problem = self._loop, self._loop.cycle.state, self.unstored
        return DriveHealth(
            status="failed" if loop.error else "degraded" if problem else "ok",
            problem=loop.error or problem,
            ready=loop.ready and not loop.error,
            ticks=cycle.ticks,
            missed=loop.deadlines.missed,
            longest_streak=loop.deadlines.longest,
            stops=cycle.stops,
            restarts=max(self._services.navigator.starts - 1, 0),
            rate=round(cycle.time_rate.measured, 2),
        )

    @property
    def unstored(self) -> str:
        """Sentences about what cannot be stored, and why; empty: everything is stored."""
        rides, limits, audit = self._services.rides, self._settings, self.audit
        ends = f"The limits in force are not stored, and end with the program: it {limits.error}."
        found = (
            (limits.error, ends),
            (rides.error, f"Rides are not stored: it {rides.error}."),
            (audit.error, f"The audit log is not stored: it {audit.error}."),
        )
        here = [text for problem, text in found if problem]
        return " ".join(filter(None, [*here, self._loop.cycle.state.unstored_rows]))

    @property
    def failure(self) -> CohelmError | None:
        """Error of the first world, without which there is nothing to drive; None: no error."""
        return self._loop.failure

    @property
    def navigator_pid(self) -> int | None:
        """Process id of the navigator; None: there is no process now."""
        return self._services.navigator.pid

    def _announce_settings(self) -> None:
        with self._announcing:
            self._send(SettingsChanged(limits=self.limits, rider=self.rider), None)

    def _send(self, message: ToPage, client: str | None) -> None:
        for listener in self._listeners:
            listener(message, client)
