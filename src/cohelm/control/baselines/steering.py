"""From a direction to drive in to inputs, for a robot that must turn and for one that need not."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.control.api import LocalProblem


@value
class Steering:
    """How a robot is steered, as plain arrays for the kernels."""

    to_input: Annotated[Floats, Shape("3 m")]
    """The inputs of each unit twist."""
    to_twist: Annotated[Floats, Shape("m 3")]
    """The twist of each unit input."""
    bounds: Annotated[Floats, Shape("4 m")]
    """Lowest and highest inputs, greatest rise and fall a second."""
    sideways: bool
    """Whether it moves any way without turning."""
    gain: float
    """Turn rate for each radian off the direction wanted, 1/s."""

    @staticmethod
    def of(problem: LocalProblem, gain: float) -> Steering:
        """That of the problem's robot, under the problem's limits."""
        motion = problem.robot.motion
        return Steering(
            to_input=np.asarray(motion.input(np.eye(3)), dtype=float),
            to_twist=np.asarray(motion.twist(np.eye(motion.inputs)), dtype=float),
            bounds=np.stack(problem.input_bounds()),
            sideways=motion.translating > 1,
            gain=gain,
        )


@njit(cache=True)
def wrapped(angle: float) -> float:
    """``angle`` in [−π, π), rad."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@njit(cache=True)
def twist_toward(
    off: float, speed: float, gain: float, sideways: bool
) -> tuple[float, float, float]:
    """The twist that drives ``off`` rad to the left of the heading at ``speed``.

    Who must turn first does: v = speed · cos(off), 0 where that is behind, and ω = gain · off.
    """
    if sideways:
        return speed * math.cos(off), speed * math.sin(off), 0.0
    return speed * max(math.cos(off), 0.0), 0.0, gain * off


@njit(cache=True)
def stepped(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    pose: Floats,
    inputs: Floats,
    vx: float,
    vy: float,
    w: float,
    to_input: Floats,
    to_twist: Floats,
    bounds: Floats,
    step: float,
    change: float,
) -> None:
    """Lets ``inputs`` (m,) approach a twist as fast as they may, and moves ``pose`` for a step.

    Both are changed in place. change: time that the inputs have to change in, s.
    """
    m = inputs.shape[0]
    x, y, turn = 0.0, 0.0, 0.0
    for i in range(m):
        wanted = vx * to_input[0, i] + vy * to_input[1, i] + w * to_input[2, i]
        wanted = min(max(wanted, bounds[0, i]), bounds[1, i])
        least, most = inputs[i] - bounds[3, i] * change, inputs[i] + bounds[2, i] * change
        inputs[i] = min(max(wanted, least), most)
        x += inputs[i] * to_twist[i, 0]
        y += inputs[i] * to_twist[i, 1]
        turn += inputs[i] * to_twist[i, 2]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    pose[0] += step * (cos * x - sin * y)
    pose[1] += step * (sin * x + cos * y)
    pose[2] += step * turn


@njit(cache=True)
def rollouts(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    start: Floats,
    now: Floats,
    directions: Floats,
    speeds: Floats,
    to_input: Floats,
    to_twist: Floats,
    bounds: Floats,
    sideways: bool,
    gain: float,
    steps: int,
    step: float,
) -> tuple[Floats, Floats]:
    """(poses (r, N+1, 3), inputs (r, N, m)) of driving in each direction (r,) at each speed (r,).

    directions: rad in the map frame.  now: (m,) what the wheels do; the first change must fit into
    half a step.
    """
    count, m = directions.shape[0], now.shape[0]
    poses = np.empty((count, steps + 1, 3))
    inputs = np.empty((count, steps, m))
    pose, u = np.empty(3), np.empty(m)
    for r in range(count):
        pose[:], u[:] = start, now
        poses[r, 0] = start
        for k in range(steps):
            off = wrapped(directions[r] - pose[2])
            vx, vy, w = twist_toward(off, speeds[r], gain, sideways)
            change = step if k > 0 else 0.5 * step
            stepped(pose, u, vx, vy, w, to_input, to_twist, bounds, step, change)
            poses[r, k + 1] = pose
            inputs[r, k] = u
    return poses, inputs
