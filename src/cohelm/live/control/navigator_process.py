"""Process of the navigator: takes a request from a pipe and returns an answer.

The answer comes first: it has the decision and what pages show of the tick, and is sent before the
log and the recorder get the tick. Garbage is collected while the control loop does not wait.
"""

from __future__ import annotations

import contextlib
import gc
import math
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import NamedTuple

import numpy as np

from cohelm.arrays import identical
from cohelm.health import NO_CHANGES, MapChanges
from cohelm.live.control.ipc import ProcessReady, ProcessSetup, StepAnswer, StepRequest
from cohelm.live.control.owner_pipe import OwnerGone, OwnerPipe, build_again
from cohelm.live.control.planning_context import planning_context_of, warm_up_wishes
from cohelm.live.control.surroundings import free_distances
from cohelm.live.control.view_model import (
    edge_cells,
    map_differences,
    navigator_state,
    route_update,
)
from cohelm.live.messages import EdgeCells, MapDifferences, RouteUpdate
from cohelm.live.sessions.mcap_recording import DriveRecording
from cohelm.live.sessions.ride_log import RideLogWriter, facts_of_log
from cohelm.messages import Mode, Observation, Request, RiderCommand
from cohelm.navigation import Navigator, Tick
from cohelm.perception import FloorEdges
from cohelm.platforms import MeasuredTruth
from cohelm.processes import end_with_owner, leave_interrupts
from cohelm.reasons import Reason
from cohelm.safety import stop
from cohelm.scenarios import RideSetup
from cohelm.simulation import World

ROUTES = "routes"
"""First warm-up case with a destination."""
_WARM_UP_STEPS = 12
"""Steps of each warm-up case."""
_EDGES_INTERVAL = 1.0
"""Minimum time between two messages of edges, s: most sweeps change some cells."""
_FULL_COLLECTION = 20
"""Steps between two full garbage collections."""


def serve_navigator(pipe: Connection, setup: ProcessSetup) -> None:
    """Main function of the process: answer requests until the owner closes the pipe.

    Any fault ends the process with its traceback on stderr; the owner starts another one.
    """
    leave_interrupts()
    end_with_owner(grace=3.0)
    ride_setup = build_again(setup)
    if ride_setup is None:
        return
    server = NavigatorServer(ride_setup, setup.changes)
    with contextlib.suppress(OwnerGone):  # the owner has closed the pipe: the drive is over
        _serve(OwnerPipe(pipe), setup, ride_setup, server)
    server.close()


def _serve(
    pipe: OwnerPipe, setup: ProcessSetup, ride_setup: RideSetup, server: NavigatorServer
) -> None:
    for progress in warm_up(ride_setup):
        if progress == ROUTES and not setup.routes:
            break
        pipe.send(ProcessReady(done=False, progress=progress))
    with DriveRecording(setup.record, ride_setup) as recording:
        gc.collect()
        gc.freeze()
        gc.disable()
        pipe.send(ProcessReady(done=True))
        while True:
            request = pipe.receive()
            if request.load_routes:
                for _ in warm_up(ride_setup):
                    pass
                gc.collect()
                gc.freeze()
            pipe.send(server.answer(request))
            server.record(request, recording)
            gc.collect(2 if request.step_id % _FULL_COLLECTION == 0 else 0)


class NavigatorServer:
    """Navigator with its last tick.

    Args:
        ride_setup: Floor, chair and parts.
        changes: Contradictions to the map that earlier rides have seen.
    """

    def __init__(self, ride_setup: RideSetup, changes: MapChanges = NO_CHANGES) -> None:
        self._navigator = Navigator(ride_setup.navigator).remembering(changes)
        self._last: Tick | None = None
        self._sweeps: Observation | None = None
        """Newest observation with scans."""
        self._free: tuple[float, ...] = ()
        self._outline = tuple((float(x), float(y)) for x, y in ride_setup.robot.outline)
        self._contradictions = np.empty((0, 3), dtype=np.int64)
        """``MapChanges.persistent_rows`` of the last answer."""
        self._grid = ride_setup.grid
        self._edges: FloorEdges | None = None
        """Edges of the last answer that had some, and its time, s."""
        self._edges_time = -math.inf
        self._ride_log = RideLogWriter(lambda: facts_of_log(ride_setup))
        self._measured = MeasuredTruth(ride_setup.robot.outline, ride_setup.grid)
        self._unstored = ""

    def answer(self, step: StepRequest) -> StepAnswer:
        """Compute one step; during a pause, the planning context only."""
        if step.paused:
            return self._paused_answer(step)
        if step.restart and self._last is not None:
            health, self._last = self._last.memory.health, None
            self._edges, self._edges_time = None, -math.inf
            if health is not None:  # the world is new, the building is not
                remembered = health.changes._replace(time=-math.inf)
                self._navigator = self._navigator.remembering(remembered)
        last = self._last
        tick = self._navigator.step(step.observation, self._shared(step.request), last)
        self._last = tick
        if tick.observation.scans or self._sweeps is None or step.restart:
            self._sweeps = tick.observation
            self._free = free_distances(self._sweeps, self._outline)
        return StepAnswer(
            step_id=step.step_id,
            mission_version=step.mission_version,
            heartbeat_seq=step.heartbeat_seq,
            decision=tick.decision,
            arrived=tick.arrived,
            state=navigator_state(tick, self._sweeps, self._free),
            route=_new_route(tick, last),
            differences=self._new_differences(tick, last),
            edges=self._new_edges(tick),
            log=self._ride_log.finished(),
            unstored=self._unstored,
            planning_context=(
                planning_context_of(tick, step.request) if step.planning_context else None
            ),
        )

    def record(self, step: StepRequest, recording: DriveRecording) -> None:
        """Record the step that was just answered."""
        if step.paused:
            return
        if step.restart:
            recording.restart()
        if step.end:
            self._ride_log.end(step.end)
        if step.begin is not None:
            self._ride_log.begin(step.begin)
        self._ride_log.summarise(step.summary)
        if self._last is None:
            return
        truth = step.truth
        if truth is None:
            truth = self._measured.at(step.observation, self._last.people)
        self._ride_log.add(self._last, truth)
        recording.add(self._last, step.truth)
        ride, ticks = self._ride_log.error, recording.error
        self._unstored = f"The log of this ride {ride}." if ride else ticks

    def close(self) -> None:
        """Write what waits of the ride's log."""
        self._ride_log.close()

    def _paused_answer(self, step: StepRequest) -> StepAnswer:
        context = planning_context_of(self._last, step.request) if self._last is not None else b""
        return StepAnswer(
            step_id=step.step_id,
            mission_version=step.mission_version,
            heartbeat_seq=step.heartbeat_seq,
            decision=stop(Reason.PAUSED),
            planning_context=context,
        )

    def _shared(self, request: Request) -> Request:
        """Return the last request if it is equal: the navigator compares by identity."""
        last = self._last.request if self._last is not None else None
        return last if last is not None and identical(last, request) else request

    def _new_differences(self, tick: Tick, last: Tick | None) -> MapDifferences | None:
        """Return the differences from the map if they are not those of the last answer."""
        if tick.memory.health is None:
            return None
        before, rows = self._contradictions, tick.memory.health.changes.persistent_rows
        self._contradictions = rows
        return None if last is not None and np.array_equal(before, rows) else map_differences(rows)

    def _new_edges(self, tick: Tick) -> EdgeCells | None:
        """Return the edges of the floor if they have changed, at most once a second."""
        floor, now = tick.memory.floor, tick.observation.time
        if floor is None or floor.edges is self._edges or now < self._edges_time + _EDGES_INTERVAL:
            return None
        self._edges, self._edges_time = floor.edges, now
        return edge_cells(floor.edges.cells, self._grid)


def _new_route(tick: Tick, last: Tick | None) -> RouteUpdate | None:
    """Return the route if it may differ from that of the last tick."""
    failure = tick.memory.planning_failure
    if last is None or tick.path is not last.path or failure is not last.memory.planning_failure:
        return route_update(tick)
    return None


class _WarmUpCase(NamedTuple):
    """Request and stick position of some warm-up steps."""

    name: str
    request: Request
    stick: tuple[float, float] = (0.0, 0.0)


def warm_up(ride_setup: RideSetup) -> Iterator[str]:
    """Drive a little in every mode, in a separate world, so that all code is compiled and loaded.

    The cases without a destination come first, in the order in which they need more.

    Yields:
        Name of the next case.
    """
    yield "world"
    world = World(ride_setup.world, ride_setup.seed)
    server = NavigatorServer(ride_setup)
    step_id = 0
    for name, request, stick in _warm_up_cases(ride_setup):
        yield name
        for _ in range(_WARM_UP_STEPS):
            observation = world.observe()
            rider = RiderCommand(heartbeat=observation.time, deflection=np.array(stick))
            step = StepRequest(
                step_id=step_id,
                mission_version=0,
                observation=replace(observation, rider=rider),
                request=replace(request, extra_clearance=0.1 * (step_id % 2)),
                truth=world.truth,
                heartbeat_seq=0,
                planning_context=step_id % _WARM_UP_STEPS == 0,
            )
            world.advance(server.answer(step).decision)
            step_id += 1


def _warm_up_cases(ride_setup: RideSetup) -> Iterator[_WarmUpCase]:
    request = replace(ride_setup.request, wishes=(), mode=Mode.SHARED, speed_limit=0.7)
    free = replace(request, goal=np.full(2, np.nan))
    for mode in (Mode.MANUAL, Mode.STOP_ONLY, Mode.ASSISTED, Mode.SHARED):
        yield _WarmUpCase(mode.value, replace(free, mode=mode), (0.4, -0.3))
    yield _WarmUpCase(ROUTES, request)
    yield _WarmUpCase("stick", request, (0.5, 0.3))
    for wish in warm_up_wishes(ride_setup):
        yield _WarmUpCase(wish.kind, replace(request, wishes=(wish,)))
    yield _WarmUpCase("autonomous", replace(request, mode=Mode.AUTONOMOUS))
    yield _WarmUpCase("standing", replace(request, speed_limit=0.0))
