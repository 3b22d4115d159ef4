"""Start of every plan: the current input, and the last plan shifted to the present."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.trajectories import limited_trajectory
from cohelm.kernels import CACHED
from cohelm.messages import LocalPlan
from cohelm.robots import InputBounds

_STALE = 0.5
"""A plan older than this is no seed, s."""
_LATENCY, _NOISE = 0.1, 0.02
"""A command is plausible for this long before odometry confirms it, s, and within m/s."""


def estimate_current_input(problem: LocalProblem, previous: LocalPlan | None) -> Floats:
    """Estimate u_{−1}, the current input of the wheels, (m,).

    It is the last command, as the gate left it, as far as odometry confirms it within its lag: this
    keeps noise out of the plan. It is limited to the robot's abilities, so that commands keep the
    limits whatever the odometry says.
    """
    robot, kinematics = problem.robot, problem.robot.motion_model
    measured = kinematics.input(problem.twist)
    n_linear, top = kinematics.translating, robot.max_speed
    if previous is None or not 0.0 <= problem.time - previous.time <= _STALE:
        return _limited(measured, robot.input_bounds, n_linear, top)
    sent = previous.command if problem.commanded is None else problem.commanded
    commanded = kinematics.input(sent)
    delay = _LATENCY + robot.actuation_lag
    return _confirmed(measured, commanded, robot.input_bounds, n_linear, top, delay)


@njit(**CACHED)
def _confirmed(
    measured: Floats,
    commanded: Floats,
    bounds: InputBounds,
    n_linear: int,
    top_speed: float,
    delay: float,
) -> Floats:
    """The commanded inputs (m,) as far as the measured ones confirm them within ``delay`` s."""
    measured = _limited(measured, bounds, n_linear, top_speed)
    out = np.empty(len(measured))
    for i in range(len(measured)):
        if not math.isfinite(commanded[i]):
            return measured
        tolerance = max(bounds.rise[i], bounds.fall[i]) * delay + _NOISE
        out[i] = min(max(commanded[i], measured[i] - tolerance), measured[i] + tolerance)
    return _limited(out, bounds, n_linear, top_speed)


@njit(**CACHED)
def _limited(inputs: Floats, bounds: InputBounds, n_linear: int, top_speed: float) -> Floats:
    """The inputs (m,) nearest to the given ones within the robot's limits.

    ``n_linear`` leading inputs are linear velocities, see ``Kinematics.translating``; their norm is
    bounded by ``top_speed``. A copy of a part of ``within_limits`` for a single input without
    limits of acceleration; rounding differs between the two.
    """
    square = 0.0
    for i in range(n_linear):
        square += inputs[i] * inputs[i]
    speed = math.sqrt(square)
    shrink = top_speed / speed if n_linear > 1 and speed > top_speed else 1.0
    out = np.empty(len(inputs))
    for i in range(len(inputs)):
        requested = shrink * inputs[i] if i < n_linear else inputs[i]
        out[i] = min(max(requested, bounds.low[i]), bounds.high[i])
    return out


def shifted_plan(
    problem: LocalProblem,
    previous: LocalPlan | None,
    current_input: Floats,
    steps: int | None = None,
    tail: Floats | None = None,
) -> Trajectory | None:
    """The last plan from now on, its inputs interpolated; None if it is too old.

    Args:
        problem: the present problem.
        previous: the last plan.
        current_input: u_{−1}, (m,).
        steps: required length of the plan; None: that of the reference.
        tail: (L, m) inputs that continue the plan; the trajectory includes them.
    """
    steps = steps or len(problem.reference.poses) - 1
    if previous is None or previous.inputs.shape != (steps, len(current_input)):
        return None
    elapsed = problem.time - previous.time
    if not 0.0 <= elapsed <= _STALE:
        return None
    inputs = previous.inputs if tail is None else np.concatenate([previous.inputs, tail])
    return limited_trajectory(problem, _shifted(inputs, previous.step, elapsed), current_input)


@njit(**CACHED)
def _shifted(inputs: Floats, step: float, elapsed: float) -> Floats:
    """Inputs (N, m) from ``elapsed`` s on, interpolated; the last one is held."""
    count = inputs.shape[0]
    out = np.empty(inputs.shape)
    j = 0  # interval of the given inputs
    for k in range(count):
        time = k * step + elapsed
        while j < count - 1 and (j + 1) * step <= time:
            j += 1
        for i in range(inputs.shape[1]):
            out[k, i] = inputs[j, i]
            if j < count - 1:
                slope = (inputs[j + 1, i] - inputs[j, i]) / ((j + 1) * step - j * step)
                out[k, i] = slope * (time - j * step) + inputs[j, i]
    return out
