"""Contract of ``control.LocalPlanner``."""

from __future__ import annotations

import dataclasses

import numpy as np

from cohelm.control.api import LocalPlanner, LocalProblem
from cohelm.geometry import transform
from cohelm.maps import distance_field
from cohelm.messages import LocalPlan, Status
from cohelm.testing.conformance import TOLERANCE, require, require_finite, steady
from cohelm.testing.scenes import local_problem, open_floor, room, walkers

_TICK = 0.05
_SCRAPE = 0.02
"""Allowed overlap of the footprint's discs with a wall's distance field, m."""


def check_local_planner(planner: LocalPlanner, *, within: float = 1.0) -> None:
    """Check a local planner: alone, in a crowd, before a wall, at rest and at speed.

    Raises:
        ConformanceError: naming the violated rule.
    """
    n, step = planner.steps, planner.step
    require(n >= 1, f"steps must be a positive number, is {n!r}")
    require(step > 0.0, f"step must be positive, is {step!r}")
    for name, problem in _problems(n, step).items():
        first = _check_plan(planner, problem, None, name, within)
        later = dataclasses.replace(problem, time=problem.time + _TICK)
        _check_plan(planner, later, first, f"{name}, with a plan before", within)
    _check_drives(planner)
    _check_no_preferred_direction(planner)


def _problems(n: int, step: float) -> dict[str, LocalProblem]:
    """Problems by their obstacles."""
    rng = np.random.default_rng(0)
    crowd = np.column_stack(
        [rng.uniform(1.5, 6.0, 10), rng.uniform(-3.0, 3.0, 10), rng.normal(0.0, 0.7, (10, 2))]
    )
    facing = np.array([[3.0, 0.05, -1.2, 0.0]])
    touching = np.array([[0.95, 0.0, 0.0, 0.0]])
    blocked = distance_field(room(boxes=[(6.0, 0.0, 6.4, 8.0)]))
    near = (4.5, 4.0, 0.0)
    return {
        "no people, at rest": local_problem(steps=n, step=step),
        "no people, at speed": local_problem(steps=n, step=step, speed=0.8),
        "a person head-on": local_problem(steps=n, step=step, speed=0.8, people=walkers(facing)),
        "a person in contact": local_problem(steps=n, step=step, people=walkers(touching)),
        "ten people": local_problem(steps=n, step=step, speed=0.6, people=walkers(crowd)),
        "a wall ahead": local_problem(steps=n, step=step, pose=near, speed=0.5, walls=blocked),
    }


def _check_plan(
    planner: LocalPlanner,
    problem: LocalProblem,
    previous: LocalPlan | None,
    when: str,
    within: float,
) -> LocalPlan:
    plan = steady(
        lambda: planner.plan(problem, previous),
        inputs=(problem, previous),
        what=f"plan ({when})",
        within=within,
    )
    require_finite(
        {
            f"the command ({when})": plan.command,
            f"the poses ({when})": plan.poses,
            f"the inputs ({when})": plan.inputs,
            f"the slack ({when})": plan.slack,
        }
    )
    require(not np.isnan(plan.smallest_barrier), f"the smallest barrier must be a number ({when})")
    require(plan.time == problem.time, f"a plan must have the problem's time ({when})")
    require(
        np.abs(plan.poses[0, :2] - problem.pose[:2]) < TOLERANCE,
        f"a plan must begin at the pose of the robot ({when})",
    )
    _check_limits(plan, problem, planner.step, when)
    if plan.status is Status.STOP:
        _check_brakes(plan, problem, when)
    else:
        _check_walls(plan, problem, when)
    return plan


def _check_limits(plan: LocalPlan, problem: LocalProblem, step: float, when: str) -> None:
    """Check that the robot can reach the command within a step of the plan."""
    robot = problem.robot
    lower, upper, rise, _ = robot.motion_model.bounds(robot.limits)
    command, now = robot.motion_model.input(plan.command), robot.motion_model.input(problem.twist)
    back = robot.motion_model.twist(command)
    require(
        np.abs(back - plan.command) < TOLERANCE,
        f"the command must be possible for the robot ({when})",
    )
    require(
        (command >= lower - TOLERANCE) & (command <= upper + TOLERANCE),
        f"the command {command} must be within the robot's limits {lower} to {upper} ({when})",
    )
    ahead = np.hypot(*plan.command[:2])
    fastest = max(problem.speed_limit, float(np.hypot(*problem.twist[:2])))
    require(ahead <= fastest + TOLERANCE, f"the command must keep the speed limit ({when})")
    most = np.maximum(rise, robot.emergency_deceleration) * step
    require(
        np.abs(command - now) <= most + TOLERANCE,
        f"the command must not jump: from {now} to {command} within {step} s ({when})",
    )


def _check_brakes(plan: LocalPlan, problem: LocalProblem, when: str) -> None:
    require(plan.reason is not None, f"a stop must have a reason ({when})")
    slower = np.hypot(*plan.command[:2]) <= np.hypot(*problem.twist[:2]) + TOLERANCE
    require(slower, f"a stop must not accelerate ({when})")


def _check_walls(plan: LocalPlan, problem: LocalProblem, when: str) -> None:
    """Check that the footprint's discs keep clear of walls at every pose of a plan."""
    centres, radius = problem.robot.discs[:, :2], problem.robot.discs[:, 2]
    points = transform(plan.poses[:, None, :], centres)
    gap = float((problem.walls.at(points) - radius).min())
    require(
        gap > -_SCRAPE, f"a plan must not lead into a wall, but enters it by {-gap:.2f} m ({when})"
    )


def _check_drives(planner: LocalPlanner) -> None:
    """Check that it drives along the reference on an open floor instead of standing still."""
    problem = local_problem(steps=planner.steps, step=planner.step)
    plan: LocalPlan | None = None
    pose, twist = problem.pose, problem.twist
    for k in range(60):
        here = local_problem(
            steps=planner.steps, step=planner.step, pose=pose, speed=float(twist[0])
        )
        plan = planner.plan(dataclasses.replace(here, time=k * _TICK, twist=twist), plan)
        twist = plan.command
        inputs = problem.robot.motion_model.input(twist)[None]
        pose = problem.robot.motion_model.rollout(pose, inputs, _TICK)[-1]
    require(
        pose[0] > 1.0, f"alone, 3 s at a requested 0.8 m/s must make progress, made {pose[0]:.2f} m"
    )
    require(
        abs(pose[1]) < 0.1, f"alone it must follow its reference, but is {pose[1]:.2f} m beside it"
    )


def _check_no_preferred_direction(planner: LocalPlanner) -> None:
    """Check that turning the world by 90° turns the plan; 1e-4 for a solver's tolerance."""
    states = np.array([[3.0, 0.6, -0.8, 0.0], [4.0, -1.5, 0.0, 0.5]])
    turned = np.column_stack([-states[:, 1], states[:, 0], -states[:, 3], states[:, 2]])
    n, step = planner.steps, planner.step
    plain = local_problem(steps=n, step=step, people=walkers(states), speed=0.5)
    other = local_problem(
        steps=n,
        step=step,
        people=walkers(turned),
        speed=0.5,
        pose=(0.0, 0.0, np.pi / 2.0),
        walls=open_floor((20.0, -20.0, np.pi / 2.0)),
    )
    change = np.abs(planner.plan(plain, None).command - planner.plan(other, None).command).max()
    require(
        change < 1e-4,
        f"turning the world by 90° must not change the command, but changes it by {change}",
    )
