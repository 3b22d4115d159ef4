"""What the baselines share: where to start, and what to do with the result."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.baselines.steering import Steering, stepped
from cohelm.control.constraints.wall_clearance import wall_barrier
from cohelm.control.sqp import OptimalControl, Solution, Value
from cohelm.control.verification import brought_to_rest
from cohelm.messages import LocalPlan, Reason, Status

_RELAXED = 0.01
"""Slack above this is reported as a relaxed plan, m."""
_SCRAPE = 0.01
"""A plan that reaches deeper than this into a wall is none, m."""
_GAINS = np.array([1.0, 4.0, 2.5])
"""Of the tracking law: along (1/s), across (rad/m²), heading (1/s); assumed."""


def along_reference(problem: LocalProblem, now: Floats, *, share: float = 1.0) -> Motion:
    """The reference's own inputs from where the robot is, with feedback on what it is beside it.

    The tracking law of Kanayama et al. (1990) with the heading's gain kept at rest:

        v = v̂ cos e_θ + k_x e_x     ω = ω̂ + k_y v̂ e_y + k_θ e_θ

    On the reference it is the reference itself. Errors are measured in the robot's frame.

    Args:
        problem: whose reference.
        now: what the wheels do, (m,).
        share: of the reference's speed that is driven; the way stays the same.
    """
    r, steering = problem.reference, Steering.of(problem, float(_GAINS[2]))
    poses, inputs = _tracking(
        problem.pose,
        now,
        r.poses,
        r.speeds,
        r.step,
        share,
        _GAINS,
        steering.to_input,
        steering.to_twist,
        steering.bounds,
        steering.sideways,
    )
    return Motion(step=r.step, poses=poses, inputs=inputs, last_input=now)


def planned(
    control: OptimalControl,
    problem: LocalProblem,
    solution: Solution,
    now: Floats,
    *,
    tolerance: float,
) -> LocalPlan:
    """The plan that a solution stands for, or braking where no motion keeps the constraints.

    None does so where slack beyond ``tolerance`` is left and braking needs no more of it, or where
    the motion would scrape along a wall.

    Args:
        control: whose terms and constraints they are.
        problem: what was asked.
        solution: the best motion found.
        now: what the wheels do, (m,).
        tolerance: slack that is put up with, m.
    """
    motion, value = solution.motion, solution.value
    status = Status.RELAXED if value.slack > _RELAXED else Status.OK
    scraping = scrapes(problem, motion)
    if scraping or value.slack > tolerance:
        rest = brought_to_rest(problem, now, len(motion.inputs))
        resting = control.value(problem, rest)
        if scraping or _violation(control, resting) <= _violation(control, value):
            motion, value, status = rest, resting, Status.STOP
    return plan_of(
        problem,
        motion,
        status,
        costs=value.costs,
        slack=value.slack,
        barrier=value.barrier,
        iterations=solution.iterations,
    )


def plan_of(  # noqa: PLR0913  # keyword-only, one meaning each
    problem: LocalProblem,
    motion: Motion,
    status: Status,
    *,
    costs: Mapping[str, float],
    slack: float = 0.0,
    barrier: float = math.inf,
    iterations: int = 0,
    candidate: str = "",
    memory: Any | None = None,
) -> LocalPlan:
    """A motion as a plan; a stop has its reason."""
    return LocalPlan(
        time=problem.time,
        step=motion.step,
        command=problem.robot.motion.twist(motion.inputs[0]),
        poses=motion.poses,
        inputs=motion.inputs,
        status=status,
        reason=Reason.NO_SAFE_PLAN if status is Status.STOP else None,
        costs=MappingProxyType(dict(costs)),
        smallest_barrier=barrier,
        slack=slack,
        iterations=iterations,
        candidate=candidate,
        memory=memory,
    )


def scrapes(problem: LocalProblem, motion: Motion) -> bool:
    """Whether a motion reaches into a wall."""
    return gap_to_walls(problem, motion) < -_SCRAPE


def gap_to_walls(problem: LocalProblem, motion: Motion) -> float:
    """The least gap between the footprint's discs and a wall along a motion, m.

    Where the robot begins nearer to one, by so much less as it does: it may leave.
    """
    walls = problem.walls
    gaps, _ = wall_barrier(
        problem.robot.discs, 0.0, motion.poses, walls.distance, walls.resolution, walls.X_MG
    )
    return float((gaps - np.minimum(gaps[:, :1], 0.0)).min())


def _violation(control: OptimalControl, value: Value) -> float:
    """The price of all slack."""
    return sum(value.costs.get(constraint.name, 0.0) for constraint in control.constraints)


@njit(cache=True)
def _tracking(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    start: Floats,
    now: Floats,
    reference: Floats,
    speeds: Floats,
    step: float,
    share: float,
    gains: Floats,
    to_input: Floats,
    to_twist: Floats,
    bounds: Floats,
    sideways: bool,
) -> tuple[Floats, Floats]:
    """(poses (N+1, 3), inputs (N, m)) of the tracking law within the limits.

    reference: (N+1, 3) and speeds: (N+1,) of it.  now: (m,).
    """
    steps = reference.shape[0] - 1
    poses, inputs = np.empty((steps + 1, 3)), np.empty((steps, now.shape[0]))
    pose, u = start.copy(), now.copy()
    poses[0] = start
    for k in range(steps):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        dx, dy = reference[k, 0] - pose[0], reference[k, 1] - pose[1]
        ahead, aside = cos * dx + sin * dy, -sin * dx + cos * dy
        off = reference[k, 2] - pose[2]
        vx = share * (speeds[k] * math.cos(off) + gains[0] * ahead)
        vy, w = 0.0, share * (reference[k + 1, 2] - reference[k, 2]) / step + gains[2] * off
        if sideways:
            vy = share * (speeds[k] * math.sin(off) + gains[0] * aside)
        else:
            w += gains[1] * share * speeds[k] * aside
        change = step if k > 0 else 0.5 * step
        stepped(pose, u, vx, vy, w, to_input, to_twist, bounds, step, change)
        poses[k + 1] = pose
        inputs[k] = u
    return poses, inputs
