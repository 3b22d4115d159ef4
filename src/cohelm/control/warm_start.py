"""Start of every plan: the current input, and the last plan shifted to the present."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, unchecked
from cohelm.control.api import LocalProblem, Motion
from cohelm.messages import LocalPlan
from cohelm.robots import InputBounds
from cohelm.robots.kinematics import within_limits

_STALE = 0.5
"""A plan older than this is no seed, s."""
_LATENCY, _NOISE = 0.1, 0.02
"""A command is plausible for this long before odometry confirms it, s, and within m/s."""


def last_input(problem: LocalProblem, previous: LocalPlan | None) -> Floats:
    """Current input of the wheels, (m,).

    The last command where odometry confirms it within its lag, else the odometry: this keeps noise
    out of the plan, and ignores a command that was overruled. It is limited to the robot's
    abilities, so that commands keep the limits whatever the odometry says.
    """
    robot, motion = problem.robot, problem.robot.motion
    measured = motion.input(problem.twist)
    over, top = motion.translating, robot.max_speed
    if previous is None or not 0.0 <= problem.time - previous.time <= _STALE:
        return _limited(measured, robot.input_bounds, over, top)
    commanded = motion.input(previous.command)
    delay = _LATENCY + robot.actuation_lag
    return _confirmed(measured, commanded, robot.input_bounds, over, top, delay)


@njit(cache=True)
def _confirmed(
    measured: Floats,
    commanded: Floats,
    bounds: InputBounds,
    translating: int,
    top_speed: float,
    delay: float,
) -> Floats:
    """The commanded inputs (m,) as far as the measured ones confirm them within ``delay`` s."""
    measured = _limited(measured, bounds, translating, top_speed)
    out = np.empty(len(measured))
    for i in range(len(measured)):
        if not math.isfinite(commanded[i]):
            return measured
        reach = max(bounds.rise[i], bounds.fall[i]) * delay + _NOISE
        out[i] = min(max(commanded[i], measured[i] - reach), measured[i] + reach)
    return _limited(out, bounds, translating, top_speed)


@njit(cache=True)
def _limited(inputs: Floats, bounds: InputBounds, translating: int, top_speed: float) -> Floats:
    """The inputs (m,) nearest to the given ones within the robot's limits."""
    square = 0.0
    for i in range(translating):
        square += inputs[i] * inputs[i]
    speed = math.sqrt(square)
    shorter = top_speed / speed if translating > 1 and speed > top_speed else 1.0
    out = np.empty(len(inputs))
    for i in range(len(inputs)):
        wanted = shorter * inputs[i] if i < translating else inputs[i]
        out[i] = min(max(wanted, bounds.low[i]), bounds.high[i])
    return out


def shifted_plan(
    problem: LocalProblem,
    previous: LocalPlan | None,
    now: Floats,
    steps: int | None = None,
    tail: Floats | None = None,
) -> Motion | None:
    """The last plan from now on, its inputs interpolated; None if it is too old.

    Args:
        problem: the present problem.
        previous: the last plan.
        now: current input, (m,).
        steps: required length of the plan; None: that of the reference.
        tail: (L, m) inputs that continue the plan; the motion includes them.
    """
    steps = steps or len(problem.reference.poses) - 1
    if previous is None or previous.inputs.shape != (steps, len(now)):
        return None
    elapsed = problem.time - previous.time
    if not 0.0 <= elapsed <= _STALE:
        return None
    given = previous.inputs if tail is None else np.vstack([previous.inputs, tail])
    return limited_motion(problem, _later(given, previous.step, elapsed), now)


@njit(cache=True)
def _later(given: Floats, step: float, elapsed: float) -> Floats:
    """Inputs (N, m) from ``elapsed`` s on, interpolated; the last one is held."""
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


def with_reference_towards(problem: LocalProblem, motion: Motion, share: float) -> LocalProblem:
    """The problem with its reference moved towards a motion by ``share``."""
    if share <= 0.0:
        return problem
    r, over = problem.reference, problem.robot.motion.translating
    poses, speeds = _blended(r.poses, r.speeds, motion.poses, motion.inputs, over, share)
    return unchecked(problem, reference=unchecked(r, poses=poses, speeds=speeds))


@njit(cache=True)
def _blended(
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


def limited_motion(problem: LocalProblem, inputs: Floats, now: Floats) -> Motion:
    """The motion of inputs (N, m) within the limits of speed and acceleration from ``now`` (m,)."""
    robot, step = problem.robot, problem.reference.step
    low, high, rise, fall = problem.input_bounds()
    sooner = np.array([[0.5 * step], [step]])  # the first change must fit into half a step
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


def braking_motion(problem: LocalProblem, now: Floats, steps: int) -> Motion:
    """Comfort braking over N = ``steps``, all inputs in proportion, so the curvature is constant.

    now: current input, (m,).
    """
    _, _, _, fall = problem.robot.input_bounds
    step = problem.reference.step
    moving, turning = now[:-1], now[-1:]
    fading = max(np.linalg.norm(moving) / fall[0], np.abs(turning).max() / fall[-1], 1e-9)
    times = (np.arange(steps) + 0.5) * step
    left = np.clip(1.0 - times / fading, 0.0, 1.0)
    return limited_motion(problem, left[:, None] * now, now)
