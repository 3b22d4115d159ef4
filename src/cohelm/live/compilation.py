"""Compilation of all kernels that rides need, without a chair that waits for them."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.control import LocalPlanner
from cohelm.evaluation import measure, run
from cohelm.live.control.navigator_process import warm_up
from cohelm.live.control.world_factory import build_world
from cohelm.live.floor_model import floor_model
from cohelm.live.page import preview_process
from cohelm.maps import distance_field
from cohelm.messages import Mode
from cohelm.perception import Detector
from cohelm.processes import end_with_owner, leave_interrupts, spawn, without_interrupts
from cohelm.scenarios import Scenario, load_scenario
from cohelm.testing.scenes import BODY, local_problem, room, scan_of, walkers

FLOOR, RIDE = "hospital", "crossing"
"""Scenarios of ``cohelm drive`` and of the examples of ``cohelm run``."""
_WITHOUT_PLANNER = frozenset({"world", Mode.MANUAL.value})
"""Cases of :func:`warm_up` in which no motion is planned."""
_POLL_PERIOD = 1.0  # s


def compile_kernels() -> Iterator[str]:
    """Run everything that a ride with the default parts needs, so that it is compiled and cached.

    A second process compiles the local planner at the same time, where there is a second
    processor.

    Yields:
        Name of the part that is compiled next, or still.
    """
    usual = gc.get_threshold()
    gc.set_threshold(200_000, 20, 100)  # most new objects stay: visiting them takes a tenth of it
    helper = spawn.Process(target=_compile_beside, name="compiler", daemon=True)
    try:
        if len(os.sched_getaffinity(0)) > 1:
            with without_interrupts():
                helper.start()
        yield "floor"
        scenario = load_scenario(FLOOR)
        floor_model(scenario, 0)
        yield "world and route planning"
        world = build_world(scenario, 0)
        yield "route previews"
        preview_process.warm_up(world.ride_setup)
        yield "detector"
        _detect(scenario)
        for case in warm_up(world.ride_setup):
            while case not in _WITHOUT_PLANNER and helper.is_alive():
                yield "local planner"
                helper.join(_POLL_PERIOD)
            yield f"navigator, {case}"
        yield "measures"
        measure(run(load_scenario(RIDE, ["time_limit=6"]), 0))
    finally:
        gc.set_threshold(*usual)
        if helper.is_alive():
            helper.terminate()


def _compile_beside() -> None:
    """Plan motions in a scene that needs neither a route nor a simulation."""
    leave_interrupts()
    end_with_owner()
    gc.set_threshold(200_000, 20, 100)
    _plan_motions(load_scenario(FLOOR))


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


def _detect(scenario: Scenario) -> None:
    detector: Detector = _default_part("detectors", scenario.detector["use"])
    pose, bodies = np.array([3.0, 4.0, 0.4]), [[6.0, 4.5, BODY], [5.0, 2.0, BODY]]
    scan = scan_of(pose=pose, discs=bodies, time=2.0)
    detector.detect(scan, pose, distance_field(room()))


def _default_part(group: str, name: str) -> Any:
    part = plugins.load(group, name)
    return part(part.Parameters())
