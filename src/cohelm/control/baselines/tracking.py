"""Parts shared by the baselines: a seed along the reference, and the plan of a result."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.baselines.steering import Steering, advance, steering_of
from cohelm.control.objective_tables import BODIES, TERMS
from cohelm.control.optimal_control import (
    RELAXED_SLACK,
    OptimalControl,
    Solution,
    TrajectoryEvaluation,
)
from cohelm.control.stack import TrackingTerms
from cohelm.control.terms import (
    Barrier,
    FinalHeading,
    GroupSpace,
    InputChange,
    InputDeviation,
    PathDistance,
    PersonalSpaceCost,
    PersonClearance,
    Progress,
    TrackReference,
    WallBarrier,
    WallClearance,
)
from cohelm.control.trajectories import braking_trajectory
from cohelm.kernels import CACHED
from cohelm.messages import LocalPlan, Reason, Status
from cohelm.robots.wall_contact import WallGrid, wall_gap, wall_grid

_MAX_DEPTH = 0.01
"""A plan that enters a wall deeper than this is rejected, m."""
_ALONG, _ACROSS, _HEADING = 1.0, 4.0, 2.5
"""Gains of the tracking law: along, 1/s; across, rad/m²; heading, 1/s; assumed."""


def tracking_terms(*, walls: WallBarrier, **people: Barrier) -> TrackingTerms:
    """Xu et al., eq. (12): tracking of the reference, inputs and their changes, and barriers.

    The weights are assumed. Terms of the social objective are absent.
    """
    absent = Barrier(l1=0.0, l2=0.0)
    return TrackingTerms(
        progress=Progress(final=0.0, mean=0.0),
        path_distance=PathDistance(weight=0.0),
        final_heading=FinalHeading(weight=0.0),
        input_effort=InputDeviation(speed=0.4, turn=0.125),
        input_change=InputChange(speed=0.04, turn=0.02),
        track_reference=TrackReference(position=0.5, heading=0.15),
        person_clearance=PersonClearance(weight=0.0, standing_share=1.0),
        personal_space=PersonalSpaceCost(weight=0.0),
        group_space=GroupSpace(weight=0.0),
        wall_clearance=WallClearance(weight=0.0),
        walls=walls,
        **{"bodies": absent, "social_space": absent, **people},
    )


def along_reference(
    problem: LocalProblem, current_input: Floats, *, share: float = 1.0
) -> Trajectory:
    """The reference's own inputs from the present pose, with feedback of the tracking error.

    The tracking law of Kanayama et al. (1990), with the heading gain also at rest:

        v = v̂ cos e_θ + k_x e_x     ω = ω̂ + k_y v̂ e_y + k_θ e_θ

    On the reference it is the reference itself. Errors are measured in the robot's frame.

    Args:
        problem: with the reference.
        current_input: u_{−1}, (m,).
        share: of the reference's speed; the path is the same.
    """
    r = problem.reference
    steering = steering_of(problem, _HEADING, r.step)
    poses, inputs = _tracking(problem.pose, current_input, r.poses, r.speeds, share, steering)
    return Trajectory(step=r.step, poses=poses, inputs=inputs, current_input=current_input)


def plan_of_solution(
    control: OptimalControl,
    problem: LocalProblem,
    solution: Solution,
    current_input: Floats,
    *,
    tolerance: float,
) -> LocalPlan:
    """The plan of a solution, or braking where no trajectory satisfies the constraints.

    The planner brakes if slack above ``tolerance`` is left and braking has no more of it, or if the
    trajectory would enter a wall.

    Args:
        control: the optimal-control problem.
        problem: the local problem.
        solution: the best trajectory found.
        current_input: u_{−1}, (m,).
        tolerance: accepted slack, m.
    """
    trajectory, evaluation = solution.trajectory, solution.evaluation
    status = Status.RELAXED if evaluation.slack > RELAXED_SLACK else Status.OK
    touching = touches_wall(problem, trajectory)
    if touching or evaluation.slack > tolerance:
        rest = braking_trajectory(problem, current_input, len(trajectory.inputs))
        at_rest = control.evaluate(problem, rest)
        if touching or _violation(at_rest) <= _violation(evaluation):
            trajectory, evaluation, status = rest, at_rest, Status.STOP
    return plan_of(
        problem,
        trajectory,
        status,
        costs=evaluation.costs,
        slack=evaluation.slack,
        smallest_barrier=evaluation.barrier,
        iterations=solution.iterations,
    )


def plan_of(
    problem: LocalProblem,
    trajectory: Trajectory,
    status: Status,
    *,
    costs: Mapping[str, float],
    **more: Any,
) -> LocalPlan:
    """A trajectory as a plan; a stop gets its reason. more: further fields of ``LocalPlan``."""
    return LocalPlan(
        time=problem.time,
        step=trajectory.step,
        command=problem.robot.motion_model.twist(trajectory.inputs[0]),
        poses=trajectory.poses,
        inputs=trajectory.inputs,
        status=status,
        reason=Reason.NO_SAFE_PLAN if status is Status.STOP else None,
        costs=MappingProxyType(dict(costs)),
        **more,
    )


def touches_wall(problem: LocalProblem, trajectory: Trajectory) -> bool:
    """Check whether a trajectory enters a wall."""
    return gap_to_walls(problem, trajectory) < -_MAX_DEPTH


def gap_to_walls(problem: LocalProblem, trajectory: Trajectory) -> float:
    """Smallest gap between the footprint's discs and a wall along a trajectory, m.

    A robot that starts inside a wall may leave it: each disc is compared with its start.
    """
    gaps = wall_gaps(problem.robot.discs, trajectory.poses, wall_grid(problem.walls))
    return float((gaps - np.minimum(gaps[:, :1], 0.0)).min())


def _violation(evaluation: TrajectoryEvaluation) -> float:
    """Price of all slack."""
    return sum(evaluation.costs[name] for name in TERMS[BODIES:])


@njit(**CACHED)
def wall_gaps(discs: Floats, poses: Floats, walls: WallGrid) -> Floats:
    """Gap of each disc (c, 3) to the nearest wall along poses (k, 3), (c, k), m."""
    out = np.empty((discs.shape[0], poses.shape[0]))
    for k in range(poses.shape[0]):
        for j in range(discs.shape[0]):
            out[j, k] = wall_gap(discs[j], poses[k], walls)
    return out


@njit(**CACHED)
def _tracking(
    start: Floats,
    current_input: Floats,
    reference: Floats,
    speeds: Floats,
    share: float,
    steering: Steering,
) -> tuple[Floats, Floats]:
    """(poses (N+1, 3), inputs (N, m)) of the tracking law within the limits.

    reference: (N+1, 3).  speeds: (N+1,) of it.  current_input: (m,).
    """
    steps, step = reference.shape[0] - 1, steering.step
    poses, inputs = np.empty((steps + 1, 3)), np.empty((steps, current_input.shape[0]))
    pose, u = start.copy(), current_input.copy()
    poses[0] = start
    for k in range(steps):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        dx, dy = reference[k, 0] - pose[0], reference[k, 1] - pose[1]
        e_x, e_y = cos * dx + sin * dy, -sin * dx + cos * dy
        e_theta = reference[k, 2] - pose[2]
        vx = share * (speeds[k] * math.cos(e_theta) + _ALONG * e_x)
        vy, w = 0.0, share * (reference[k + 1, 2] - reference[k, 2]) / step + _HEADING * e_theta
        if steering.holonomic:
            vy = share * (speeds[k] * math.sin(e_theta) + _ALONG * e_y)
        else:
            w += _ACROSS * share * speeds[k] * e_y
        advance(pose, u, (vx, vy, w), steering, k)
        poses[k + 1] = pose
        inputs[k] = u
    return poses, inputs
