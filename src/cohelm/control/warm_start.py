"""What every planner that looks ahead begins with: the wheels now, and the last plan shifted."""

from __future__ import annotations

import numpy as np

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
    motion = problem.robot.motion
    measured = _possible(problem, motion.input(problem.twist))
    if previous is None or not 0.0 <= problem.time - previous.time <= _STALE:
        return measured
    commanded = motion.input(previous.command)
    if not np.isfinite(commanded).all():
        return measured
    _, _, rise, fall = motion.bounds(problem.robot.limits)
    reach = np.maximum(rise, fall) * (_LATENCY + problem.robot.actuation_lag) + _NOISE
    return _possible(problem, np.clip(commanded, measured - reach, measured + reach))


def _possible(problem: LocalProblem, inputs: Floats) -> Floats:
    """Inputs (m,), or the nearest that the robot's limits allow."""
    robot = problem.robot
    low, high, _, _ = robot.motion.bounds(robot.limits)
    over = robot.motion.translating
    speed = float(np.linalg.norm(inputs[:over]))
    within = np.array(inputs, dtype=float)
    if over > 1 and speed > robot.max_speed:
        within[:over] *= robot.max_speed / speed
    possible: Floats = np.clip(within, low, high)
    return possible


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
    times = np.arange(len(given)) * step
    inputs = np.stack([np.interp(times + elapsed, times, column) for column in given.T], axis=-1)
    return followed(problem, inputs, now)


def towards(problem: LocalProblem, motion: Motion, share: float) -> LocalProblem:
    """The problem with the reference moved towards a motion by ``share``."""
    if share <= 0.0:
        return problem
    r, over = problem.reference, problem.robot.motion.translating
    speeds = np.append(np.linalg.norm(motion.inputs[:, :over], axis=1), r.speeds[-1])
    blended = unchecked(
        r,
        poses=r.poses + share * (motion.poses - r.poses),
        speeds=r.speeds + share * (speeds - r.speeds),
    )
    return unchecked(problem, reference=blended)


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
