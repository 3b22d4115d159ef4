"""A room, a chair that executes its commands, and stub parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm import plugins
from cohelm.control import LocalProblem
from cohelm.health import HealthParameters
from cohelm.messages import (
    LocalPlan,
    Mode,
    Observation,
    Path,
    Request,
    RiderCommand,
    Status,
    WishReport,
)
from cohelm.navigation import Navigator, NavigatorSetup, Tick
from cohelm.planning import RouteProblem
from cohelm.robots import load_robot, move
from cohelm.testing.scenes import room, scan_of

TICK = 0.05
START = (2.0, 4.0, 0.0)
GOAL = (9.0, 4.0)
UNTIMED = frozenset({"durations"})


class Straight:
    """A global planner: a straight line, and how often it was asked; or the error it is given."""

    def __init__(self, error: Exception | None = None) -> None:
        self.error = error
        self.asked: list[RouteProblem] = []

    def plan(self, problem: RouteProblem) -> Path:
        self.asked.append(problem)
        if self.error is not None:
            raise self.error
        points = np.linspace(problem.start, problem.goal, 200)
        length = float(np.hypot(*(problem.goal - problem.start)))
        return Path(
            points=points,
            length=length,
            cost=length,
            method="straight",
            wishes=WishReport(closest=np.zeros(len(problem.wishes))),
            without_wishes=points,
        )


class Fixed:
    """A local planner that always wants the same; or raises the error it is given."""

    steps, step = 10, 0.1

    def __init__(
        self,
        twist: object = (0.5, 0.0, 0.0),
        *,
        error: Exception | None = None,
        **changes: object,
    ) -> None:
        self.twist, self.error, self.changes = np.array(twist), error, changes
        self.asked: list[LocalProblem] = []

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        self.asked.append(problem)
        if self.error is not None:
            raise self.error
        plan = LocalPlan(
            time=problem.time,
            step=self.step,
            command=self.twist,
            poses=np.zeros((self.steps + 1, 3)),
            inputs=np.zeros((self.steps, 2)),
            status=Status.OK,
        )
        return replace(plan, **self.changes)


def navigator(**changes: object) -> Navigator:
    """In an empty room of 12 × 8 m, with the parts used by default, unless told otherwise."""
    setup = NavigatorSetup(
        # Scripted observations repeat sweeps and leave the chair where it is.
        health=HealthParameters(enabled=False),
        grid=room(),
        robot=load_robot("quantum_q6_edge"),
        global_planner=plugins.build("global_planners", "upf"),
        local_planner=plugins.build("local_planners", "ss_mpc_dcbf"),
        detector=plugins.build("detectors", "scan_clusters"),
        cloud_detector=plugins.build("cloud_detectors", "cloud_clusters"),
        tracker=plugins.build("trackers", "kalman"),
        group_detector=plugins.build("group_detectors", "no_groups"),
        predictor=plugins.build("predictors", "constant_velocity"),
        social_model=plugins.build("social_models", "personal_space"),
    )
    return Navigator(replace(setup, **changes))


def request(mode: Mode = Mode.SHARED, goal: object = GOAL, **changes: object) -> Request:
    """To the other end of the room."""
    return Request(goal=np.array(goal), mode=mode, **changes)


def observation(
    k: int = 0,
    pose: object = START,
    twist: object = (0.0, 0.0, 0.0),
    stick: object = (0.0, 0.0),
    discs: object = (),
    **changes: object,
) -> Observation:
    """What is known at tick k; a scan comes every second one."""
    time, pose = k * TICK, np.asarray(pose, dtype=float)
    scans = (scan_of(pose=pose, discs=discs, time=time, beams=180),) if k % 2 == 0 else ()
    rider = None if stick is None else RiderCommand(heartbeat=time, deflection=np.array(stick))
    good = Observation(
        time=time,
        pose=pose,
        pose_time=time,
        twist=np.asarray(twist, dtype=float),
        twist_time=time,
        scans=scans,
        rider=rider,
    )
    return replace(good, **changes)


def ride(
    steered: Navigator,
    ticks: int,
    *,
    stick: object = lambda k: (0.0, 0.0),
    discs: object = lambda k: (),
    asked: object = lambda k: request(),
) -> list[Tick]:
    """The ticks of a chair that at once does what it is told."""
    pose, twist = np.array(START), np.zeros(3)
    out: list[Tick] = []
    for k in range(ticks):
        seen = observation(k, pose, twist, stick(k), discs(k))
        out.append(steered.step(seen, asked(k), out[-1] if out else None))
        twist = out[-1].decision.twist
        pose = move(pose, twist, TICK)
    return out
