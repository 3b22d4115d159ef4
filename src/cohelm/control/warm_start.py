"""What every planner that looks ahead begins with: the wheels now, and the last plan shifted."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, unchecked
from cohelm.control.api import LocalProblem, Motion
from cohelm.messages import LocalPlan
from cohelm.robots.kinematics import within_limits

_STALE = 0.5
"""A plan older than this is no seed, s."""
_LATENCY, _NOISE = 0.1, 0.02
"""A command counts as believable for this long before odometry shows it, s, and within m/s."""


def last_input(problem: LocalProblem, previous: LocalPlan | None) -> Floats:
    """What the wheels do now, (m,).

    The last command where the odometry bears it out within its lag, else what odometry says: noise
    stays out of the plan, and a command that was overruled is not believed. Nor is more than the
    robot can do: commands begin here, and keep the limits whatever odometry says.
    """
    robot, motion = problem.robot, problem.robot.motion
    measured = motion.input(problem.twist)
    low, high, rise, fall = robot.input_bounds
    over, top = motion.translating, robot.max_speed
    if previous is None or not 0.0 <= problem.time - previous.time <= _STALE:
        return _possible(measured, low, high, over, top)
    commanded = motion.input(previous.command)
    lasts = _LATENCY + robot.actuation_lag
    return _believed(measured, commanded, low, high, rise, fall, over, top, lasts)


@njit(cache=True)
def _believed(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    measured: Floats,
    commanded: Floats,
    low: Floats,
    high: Floats,
    rise: Floats,
    fall: Floats,
    translating: int,
    top_speed: float,
    lasts: float,
) -> Floats:
    """The commanded inputs (m,) as far as the measured ones bear them out within ``lasts`` s."""
    measured = _possible(measured, low, high, translating, top_speed)
    out = np.empty(len(measured))
    for i in range(len(measured)):
        if not math.isfinite(commanded[i]):
            return measured
        reach = max(rise[i], fall[i]) * lasts + _NOISE
        out[i] = min(max(commanded[i], measured[i] - reach), measured[i] + reach)
    return _possible(out, low, high, translating, top_speed)


@njit(cache=True)
def _possible(
    inputs: Floats, low: Floats, high: Floats, translating: int, top_speed: float
) -> Floats:
    """Inputs (m,), or the nearest that the robot's limits allow."""
    square = 0.0
    for i in range(translating):
        square += inputs[i] * inputs[i]
    speed = math.sqrt(square)
    shorter = top_speed / speed if translating > 1 and speed > top_speed else 1.0
    out = np.empty(len(inputs))
    for i in range(len(inputs)):
        wanted = shorter * inputs[i] if i < translating else inputs[i]
        out[i] = min(max(wanted, low[i]), high[i])
    return out


def shifted(
    problem: LocalProblem,
    previous: LocalPlan | None,
    now: Floats,
    steps: int | None = None,
    beyond: Floats | None = None,
) -> Motion | None:
    """The last plan from now on, its inputs interpolated; None where it is too old.

    Args:
        problem: what is asked now.
        previous: the last plan.
        now: what the wheels do, (m,).
        steps: how many it must have to be of use; None: as many as the reference.
        beyond: (L, m) inputs that were meant to follow on the plan's; the motion has them, too.
    """
    steps = steps or len(problem.reference.poses) - 1
    if previous is None or previous.inputs.shape != (steps, len(now)):
        return None
    elapsed = problem.time - previous.time
    if not 0.0 <= elapsed <= _STALE:
        return None
    step = previous.step
    given = previous.inputs if beyond is None else np.vstack([previous.inputs, beyond])
    return followed(problem, _later(given, step, elapsed), now)


@njit(cache=True)
def _later(given: Floats, step: float, elapsed: float) -> Floats:
    """Inputs (N, m) from ``elapsed`` s on, interpolated; the last one lasts."""
    count = given.shape[0]
    out = np.empty(given.shape)
    at = 0
    for k in range(count):
        time = k * step + elapsed
        while at < count - 1 and (at + 1) * step <= time:
            at += 1
        for i in range(given.shape[1]):
            out[k, i] = given[at, i]
            if at < count - 1:
                slope = (given[at + 1, i] - given[at, i]) / ((at + 1) * step - at * step)
                out[k, i] = slope * (time - at * step) + given[at, i]
    return out


def towards(problem: LocalProblem, motion: Motion, share: float) -> LocalProblem:
    """The problem with the reference moved towards a motion by ``share``."""
    if share <= 0.0:
        return problem
    r, over = problem.reference, problem.robot.motion.translating
    poses, speeds = _blended(r.poses, r.speeds, motion.poses, motion.inputs, over, share)
    return unchecked(problem, reference=unchecked(r, poses=poses, speeds=speeds))


@njit(cache=True)
def _blended(  # a kernel takes plain arrays
    poses: Floats, speeds: Floats, to: Floats, inputs: Floats, translating: int, share: float
) -> tuple[Floats, Floats]:
    """(poses (N+1, 3), speeds (N+1,)) moved by ``share`` to others and to the inputs' speeds."""
    moved, sped = np.empty(poses.shape), np.empty(speeds.shape)
    last = len(speeds) - 1
    for k in range(last + 1):
        for a in range(3):
            moved[k, a] = poses[k, a] + share * (to[k, a] - poses[k, a])
        square = 0.0
        for i in range(translating if k < last else 0):
            square += inputs[k, i] * inputs[k, i]
        speed = math.sqrt(square) if k < last else speeds[last]
        sped[k] = speeds[k] + share * (speed - speeds[k])
    return moved, sped


def followed(problem: LocalProblem, inputs: Floats, now: Floats) -> Motion:
    """The motion that inputs (N, m) lead to, made to obey the limits on speed and change."""
    robot, step = problem.robot, problem.reference.step
    low, high, rise, fall = problem.input_bounds()
    sooner = np.array([[0.5 * step], [step]])  # the first change is due within a tick
    allowed = within_limits(
        np.asarray(inputs, dtype=float),
        now,
        low,
        high,
        rise * sooner,
        fall * sooner,
        robot.motion.translating,
        problem.top_speed,
    )
    poses = robot.motion.rollout(problem.pose, allowed, step)
    return Motion(step=step, poses=poses, inputs=allowed, last_input=now)
