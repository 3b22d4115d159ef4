"""Steering law: from a direction to inputs, for robots with and without sideways motion."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem
from cohelm.kernels import CACHED, callee
from cohelm.robots import InputBounds


class Steering(NamedTuple):
    """Steering of a robot for compiled code."""

    to_input: Floats
    """(3, m) inputs of each unit twist."""
    to_twist: Floats
    """(m, 3) twist of each unit input."""
    bounds: InputBounds
    holonomic: bool
    """The robot moves in any direction without turning."""
    gain: float
    """Turn rate per radian of heading error, 1/s."""
    step: float
    """s."""


def steering_of(problem: LocalProblem, gain: float, step: float) -> Steering:
    """Steering of the problem's robot, under the problem's limits."""
    kinematics = problem.robot.motion_model
    return Steering(
        to_input=np.asarray(kinematics.input(np.eye(3)), dtype=float),
        to_twist=np.asarray(kinematics.twist(np.eye(kinematics.inputs)), dtype=float),
        bounds=InputBounds(*(np.array(part) for part in problem.input_bounds())),
        holonomic=kinematics.translating > 1,
        gain=gain,
        step=step,
    )


@callee()
def wrapped(angle: float) -> float:
    """``angle`` in [−π, π), rad."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@callee()
def twist_toward(
    heading_error: float, speed: float, steering: Steering
) -> tuple[float, float, float]:
    """The twist that drives at ``speed`` in a direction ``heading_error`` rad left of the heading.

    A robot that must turn first has v = speed · cos(error), 0 if that is behind, and
    ω = gain · error.
    """
    if steering.holonomic:
        return speed * math.cos(heading_error), speed * math.sin(heading_error), 0.0
    return speed * max(math.cos(heading_error), 0.0), 0.0, steering.gain * heading_error


@callee()
def advance(
    pose: Floats, inputs: Floats, twist: tuple[float, float, float], steering: Steering, k: int
) -> None:
    """Move ``inputs`` (m,) towards a twist within the limits, and ``pose`` by step k, in place.

    The first step, k = 0, allows half a change. Each input is limited by itself, and the pose moves
    along the heading at the start of the step.
    """
    bounds, step = steering.bounds, steering.step
    to_input, to_twist = steering.to_input, steering.to_twist
    vx, vy, w = twist
    change = step if k > 0 else 0.5 * step
    x, y, turn = 0.0, 0.0, 0.0
    for i in range(inputs.shape[0]):
        requested = vx * to_input[0, i] + vy * to_input[1, i] + w * to_input[2, i]
        requested = min(max(requested, bounds.low[i]), bounds.high[i])
        low, high = inputs[i] - bounds.fall[i] * change, inputs[i] + bounds.rise[i] * change
        inputs[i] = min(max(requested, low), high)
        x += inputs[i] * to_twist[i, 0]
        y += inputs[i] * to_twist[i, 1]
        turn += inputs[i] * to_twist[i, 2]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    pose[0] += step * (cos * x - sin * y)
    pose[1] += step * (sin * x + cos * y)
    pose[2] += step * turn


@njit(**CACHED)
def roll_out_directions(
    start: Floats,
    current_input: Floats,
    directions: Floats,
    speeds: Floats,
    steering: Steering,
    steps: int,
) -> tuple[Floats, Floats]:
    """(poses (r, N+1, 3), inputs (r, N, m)) of driving in each direction (r,) at each speed (r,).

    directions: rad in the map frame.  current_input: current input, (m,).
    """
    count, m = directions.shape[0], current_input.shape[0]
    poses = np.empty((count, steps + 1, 3))
    inputs = np.empty((count, steps, m))
    pose, u = np.empty(3), np.empty(m)
    for r in range(count):
        pose[:], u[:] = start, current_input
        poses[r, 0] = start
        for k in range(steps):
            heading_error = wrapped(directions[r] - pose[2])
            advance(pose, u, twist_toward(heading_error, speeds[r], steering), steering, k)
            poses[r, k + 1] = pose
            inputs[r, k] = u
    return poses, inputs
