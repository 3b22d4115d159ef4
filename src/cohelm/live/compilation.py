"""Compilation of all kernels that rides need, without a chair that waits for them."""

from __future__ import annotations

import contextlib
import gc
import os
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection
from threading import Event, Thread
from typing import Any

import numpy as np

from cohelm import kernel_cache, plugins
from cohelm.control import LocalPlanner
from cohelm.evaluation import measure, run
from cohelm.live.control.ipc import CompileStatus
from cohelm.live.control.navigator_process import ROUTES, warm_up
from cohelm.live.control.owner_pipe import OwnerGone, OwnerPipe
from cohelm.live.control.world_factory import build_world
from cohelm.live.floor_model import floor_model
from cohelm.live.page import preview_process
from cohelm.maps import distance_field
from cohelm.messages import Observation
from cohelm.perception import PerceptionParts, perceive
from cohelm.processes import end_with_owner, leave_interrupts, spawn, without_interrupts
from cohelm.reasons import Reason
from cohelm.safety import stop
from cohelm.scenarios import Scenario, load_scenario
from cohelm.scenarios.scenario import PARTS, robot_of
from cohelm.testing.scenes import BODY, local_problem, room, scan_of, walkers

FLOOR, RIDE = "hospital", "crossing"
"""Scenarios of ``cohelm drive`` and of the examples of ``cohelm run``."""
_POLL_PERIOD = 1.0  # s
_CROWD_STEPS = 400
"""Steps in which somebody loses their way, which kernels of their own find again."""


def compile_kernels(*, alone: bool = False) -> Iterator[str]:
    """Run everything that a ride with the default parts needs, so that it is compiled and cached.

    In the order in which a rider needs it: first what a chair needs that its rider steers, then
    routes. A second process compiles perception and the local planner at the same time, where there
    is a second processor.

    Args:
        alone: True: this process compiles all.

    Yields:
        Name of the part that is compiled next, or still.
    """
    usual = gc.get_threshold()
    gc.set_threshold(200_000, 20, 100)  # most new objects stay: visiting them takes a tenth of it
    perceives, theirs = spawn.Pipe(duplex=False)
    helper = spawn.Process(target=_compile_beside, args=(theirs,), name="compiler", daemon=True)
    try:
        if len(os.sched_getaffinity(0)) > 1 and not alone:
            with without_interrupts():
                helper.start()
        yield "floor"
        scenario = load_scenario(FLOOR)
        floor_model(scenario, 0)
        yield "world and route planning"
        world = build_world(scenario, 0)
        yield "crowd"
        for _ in range(_CROWD_STEPS):
            world.apply(stop(Reason.STARTING))
        while helper.is_alive() and not perceives.poll(_POLL_PERIOD):
            yield "perception"
        for case in warm_up(world.ride_setup):
            if case == ROUTES:
                yield ROUTES
                preview_process.warm_up(world.ride_setup)
                while helper.is_alive():
                    yield "local planner"
                    helper.join(_POLL_PERIOD)
            yield f"navigator, {case}"
        yield "measures"
        measure(run(load_scenario(RIDE, ["time_limit=6"]), 0))
    finally:
        gc.set_threshold(*usual)
        if helper.is_alive():
            helper.terminate()


def serve_compilation(pipe: Connection, _: None) -> None:
    """Main function of a process that compiles, and tells its owner every second how far it is.

    A fault ends it with its traceback on stderr; what is missing is compiled when it is needed.
    """
    leave_interrupts()
    end_with_owner()
    owner, state, steerable, end = OwnerPipe(pipe), kernel_cache.state(), Event(), Event()
    teller = Thread(target=_tell, args=(owner, steerable, end), daemon=True)
    teller.start()
    for part in compile_kernels():
        if part == ROUTES:
            steerable.set()
    if not kernel_cache.unsaved():
        kernel_cache.mark_complete(state)
    end.set()
    teller.join()


def _tell(owner: OwnerPipe, steerable: Event, end: Event) -> None:
    progress = kernel_cache.CompileProgress()
    with contextlib.suppress(OwnerGone):
        while not end.wait(_POLL_PERIOD):
            with contextlib.suppress(OSError):  # a file has just gone
                share, left = progress.estimate()
                ready = steerable.is_set()
                owner.send(CompileStatus(share=share, left=left, steerable=ready))
        owner.send(CompileStatus(share=1.0, steerable=True, done=True))


def _compile_beside(perceives: Connection) -> None:
    """Perceive, then plan motions, in a scene that needs neither a route nor a simulation."""
    leave_interrupts()
    end_with_owner()
    gc.set_threshold(200_000, 20, 100)
    scenario = load_scenario(FLOOR)
    _perceive(scenario)
    perceives.send(True)
    _plan_motions(scenario)


def _plan_motions(scenario: Scenario) -> None:
    planner: LocalPlanner = _default_part("local_planners", scenario.local_planner["use"])
    states = [[6.0, 4.6, -0.8, 0.0], [5.5, 2.5, 0.0, 0.6], [7.0, 5.5, 0.0, 0.0]]
    problem = local_problem(
        steps=planner.steps,
        step=planner.step,
        people=walkers(states),
        walls=distance_field(room(boxes=[(8.0, 0.0, 8.4, 6.0)])),
        pose=(4.0, 4.0, 0.0),
        speed=0.5,
    )
    plan = planner.plan(problem, None)
    planner.plan(replace(problem, time=0.05), plan)


def _perceive(scenario: Scenario) -> None:
    """Track two walkers in an empty room by a scanner."""
    names = ("detector", "cloud_detector", "tracker", "group_detector")
    made = {name: _default_part(PARTS[name][0], getattr(scenario, name)["use"]) for name in names}
    parts = PerceptionParts(**made, outline=robot_of(scenario).outline)
    pose, walls, memory = np.array([3.0, 4.0, 0.4]), distance_field(room()), None
    for k in range(8):
        bodies = [[6.0 - 0.05 * k, 4.5, BODY], [5.0, 2.0 + 0.05 * k, BODY]]
        scan = scan_of(pose=pose, discs=bodies, time=0.1 * k)
        seen = Observation.at_rest(0.1 * k, pose=pose, scans=(scan,))
        _, memory = perceive(parts, seen, walls, memory)


def _default_part(group: str, name: str) -> Any:
    part = plugins.load(group, name)
    return part(part.Parameters())
