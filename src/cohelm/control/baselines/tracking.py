"""Parts shared by the baselines: a seed along the reference, and the plan of a result."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.baselines.steering import Steering, advance, steering_of
from cohelm.control.sqp import MotionValue, OptimalControl, Solution
from cohelm.control.terms.wall_clearance import wall_barrier
from cohelm.control.warm_start import braking_motion
from cohelm.messages import LocalPlan, Reason, Status
from cohelm.robots.contact import wall_grid

_RELAXED = 0.01
"""Slack above this is reported as a relaxed plan, m."""
_SCRAPE = 0.01
"""A plan that enters a wall deeper than this is rejected, m."""
_ALONG, _ACROSS, _HEADING = 1.0, 4.0, 2.5
"""Gains of the tracking law: along, 1/s; across, rad/m²; heading, 1/s; assumed."""


def along_reference(problem: LocalProblem, now: Floats, *, share: float = 1.0) -> Motion:
    """The reference's own inputs from the present pose, with feedback of the tracking error.

    The tracking law of Kanayama et al. (1990), with the heading gain also at rest:

        v = v̂ cos e_θ + k_x e_x     ω = ω̂ + k_y v̂ e_y + k_θ e_θ

    On the reference it is the reference itself. Errors are measured in the robot's frame.

    Args:
        problem: with the reference.
        now: current input, (m,).
        share: of the reference's speed; the path is the same.
    """
    r = problem.reference
    steering = steering_of(problem, _HEADING, r.step)
    poses, inputs = _tracking(problem.pose, now, r.poses, r.speeds, share, steering)
    return Motion(step=r.step, poses=poses, inputs=inputs, last_input=now)


def plan_of_solution(
    control: OptimalControl,
    problem: LocalProblem,
    solution: Solution,
    now: Floats,
    *,
    tolerance: float,
) -> LocalPlan:
    """The plan of a solution, or braking where no motion satisfies the constraints.

    The planner brakes if slack above ``tolerance`` is left and braking has no more of it, or if the
    motion would scrape along a wall.

    Args:
        control: the optimal-control problem.
        problem: the local problem.
        solution: the best motion found.
        now: current input, (m,).
        tolerance: accepted slack, m.
    """
    motion, value = solution.motion, solution.value
    status = Status.RELAXED if value.slack > _RELAXED else Status.OK
    scraping = scrapes(problem, motion)
    if scraping or value.slack > tolerance:
        rest = braking_motion(problem, now, len(motion.inputs))
        resting = control.value(problem, rest)
        if scraping or _violation(control, resting) <= _violation(control, value):
            motion, value, status = rest, resting, Status.STOP
    return plan_of(
        problem,
        motion,
        status,
        costs=value.costs,
        slack=value.slack,
        smallest_barrier=value.barrier,
        iterations=solution.iterations,
    )


def plan_of(
    problem: LocalProblem,
    motion: Motion,
    status: Status,
    *,
    costs: Mapping[str, float],
    **more: Any,
) -> LocalPlan:
    """A motion as a plan; a stop gets its reason. more: further fields of ``LocalPlan``."""
    return LocalPlan(
        time=problem.time,
        step=motion.step,
        command=problem.robot.motion.twist(motion.inputs[0]),
        poses=motion.poses,
        inputs=motion.inputs,
        status=status,
        reason=Reason.NO_SAFE_PLAN if status is Status.STOP else None,
        costs=MappingProxyType(dict(costs)),
        **more,
    )


def scrapes(problem: LocalProblem, motion: Motion) -> bool:
    """Check whether a motion enters a wall."""
    return gap_to_walls(problem, motion) < -_SCRAPE


def gap_to_walls(problem: LocalProblem, motion: Motion) -> float:
    """Smallest gap between the footprint's discs and a wall along a motion, m.

    A robot that starts inside a wall may leave it: each disc is compared with its start.
    """
    gaps, _ = wall_barrier(problem.robot.discs, 0.0, motion.poses, wall_grid(problem.walls))
    return float((gaps - np.minimum(gaps[:, :1], 0.0)).min())


def _violation(control: OptimalControl, value: MotionValue) -> float:
    """Penalty of all slack."""
    return sum(value.costs.get(constraint.name, 0.0) for constraint in control.constraints)


@njit(cache=True)
def _tracking(
    start: Floats,
    now: Floats,
    reference: Floats,
    speeds: Floats,
    share: float,
    steering: Steering,
) -> tuple[Floats, Floats]:
    """(poses (N+1, 3), inputs (N, m)) of the tracking law within the limits.

    reference: (N+1, 3).  speeds: (N+1,) of it.  now: (m,).
    """
    steps, step = reference.shape[0] - 1, steering.step
    poses, inputs = np.empty((steps + 1, 3)), np.empty((steps, now.shape[0]))
    pose, u = start.copy(), now.copy()
    poses[0] = start
    for k in range(steps):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        dx, dy = reference[k, 0] - pose[0], reference[k, 1] - pose[1]
        ahead, aside = cos * dx + sin * dy, -sin * dx + cos * dy
        off = reference[k, 2] - pose[2]
        vx = share * (speeds[k] * math.cos(off) + _ALONG * ahead)
        vy, w = 0.0, share * (reference[k + 1, 2] - reference[k, 2]) / step + _HEADING * off
        if steering.sideways:
            vy = share * (speeds[k] * math.sin(off) + _ALONG * aside)
        else:
            w += _ACROSS * share * speeds[k] * aside
        advance(pose, u, (vx, vy, w), steering, k)
        poses[k + 1] = pose
        inputs[k] = u
    return poses, inputs
