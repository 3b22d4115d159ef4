"""Trajectories within the robot's limits: given inputs, and comfort braking."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.robots import Robot
from cohelm.robots.kinematics import within_limits

TICK = 0.05
"""Time between two decisions, s."""
PLANNED_BRAKING = 0.75
"""Share of the comfort deceleration that is planned with; the rest is for what is not foreseen."""

_GENTLE = 0.75
"""Share of the comfort deceleration with which the robot stops at its goal."""


def limited_trajectory(problem: LocalProblem, inputs: Floats, current_input: Floats) -> Trajectory:
    """The trajectory of inputs (N, m) within the limits of speed and acceleration.

    current_input: u_{−1}, (m,).
    """
    robot, step = problem.robot, problem.reference.step
    low, high, rise, fall = problem.input_bounds()
    durations = np.array([[TICK], [step]])  # the first change must fit until the next decision
    allowed = within_limits(
        np.asarray(inputs, dtype=float),
        current_input,
        low,
        high,
        rise * durations,
        fall * durations,
        robot.motion_model.translating,
        problem.top_speed,
    )
    poses = robot.motion_model.rollout(problem.pose, allowed, step)
    return Trajectory(step=step, poses=poses, inputs=allowed, current_input=current_input)


def braking_trajectory(
    problem: LocalProblem, current_input: Floats, steps: int, *, share: float = 1.0
) -> Trajectory:
    """Comfort braking over N = ``steps``, all inputs in proportion, so the curvature is constant.

    Args:
        problem: the present problem.
        current_input: u_{−1}, (m,).
        steps: N.
        share: of the comfort deceleration.
    """
    _, _, _, fall = problem.robot.input_bounds
    fall = fall * np.append(np.full(len(current_input) - 1, share), 1.0)
    step = problem.reference.step
    linear, angular = current_input[:-1], current_input[-1:]
    duration = max(np.linalg.norm(linear) / fall[0], np.abs(angular).max() / fall[-1], 1e-9)
    times = TICK + np.arange(steps) * step
    remaining = np.clip(1.0 - times / duration, 0.0, 1.0)
    return limited_trajectory(problem, remaining[:, None] * current_input, current_input)


def gentle_stop(robot: Robot, twist: Floats) -> Floats:
    """The command (3,) after ``twist`` in a stop at a part of the comfort deceleration; 0 at rest.

    It follows from the last command and not from odometry, which lags behind it.
    """
    inputs = robot.motion_model.input(twist)
    fading = float(np.linalg.norm(inputs[:-1])) / (_GENTLE * robot.max_deceleration)
    if fading <= TICK:
        return np.zeros(3)
    return robot.motion_model.twist((1.0 - TICK / fading) * inputs)
