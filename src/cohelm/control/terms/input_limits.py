"""Limits of speed and acceleration: the set U of Xu et al., eq. (11)."""

from __future__ import annotations

import functools

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Integers, read_only
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Motion
from cohelm.robots import InputBounds, Kinematics

_FAR = 1e6
"""No bound, m/s."""
_NOTHING = ConstraintValues(slack=np.empty(0))


class InputLimits:
    """Hard bounds on inputs and on their change; linear, so exact in the quadratic program.

    A velocity with two components is also bounded by the facets of a polygon, see
    ``Kinematics.facets``. Where the robot already exceeds a bound (a limit lowered during the ride)
    the bound opens as far as braking needs, so that the problem stays feasible.
    """

    class Parameters(Model):
        """Time of the first change."""

        tick: float = Field(0.05, gt=0.0, le=1.0)
        """Time between two commands, s: the first change must fit into it."""

    name = "input_limits"
    l1 = 0.0
    l2 = 0.0

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def values(self, problem: LocalProblem, motion: Motion) -> ConstraintValues:
        """None: these bounds are hard, and no barrier."""
        del problem, motion
        return _NOTHING

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, values: ConstraintValues
    ) -> ConstraintRows:
        """Rise and fall of every input at every step, the facets; lowest and highest inputs."""
        del sensitivity, values
        kinematics = problem.robot.motion
        jacobian, key, hard = _constant(len(motion.inputs), kinematics)
        margin, upper, low, high = _rows(
            problem.input_bounds(),
            motion.last_input,
            motion.inputs,
            motion.step,
            self.parameters.tick,
        )
        if len(kinematics.facets):
            excess = motion.inputs @ kinematics.facets.T
            slower = (self.top_speeds(problem, motion) - excess).ravel()
            margin = np.concatenate([margin, slower])
            upper = np.concatenate([upper, np.full(len(slower), _FAR)])
        return ConstraintRows(
            margin=margin,
            jacobian=jacobian,
            group=hard,
            key=key,
            keys=len(key),
            upper=upper,
            low=low,
            high=high,
        )

    def bounds(self, problem: LocalProblem, motion: Motion) -> InputBounds:
        """Bounds at each step, (N, m) each; rise and fall within the step."""
        limits, tick = problem.input_bounds(), self.parameters.tick
        return _bounds(limits, motion.last_input, len(motion.inputs), motion.step, tick)

    def top_speeds(self, problem: LocalProblem, motion: Motion) -> Floats:
        """Bounds on F u of each facet at each step, (N, f): the top speed, or braking to it."""
        kinematics, now = problem.robot.motion, motion.last_input
        _, _, rise, fall = problem.input_bounds()
        since = self.parameters.tick + motion.step * np.arange(len(motion.inputs))[:, None]
        braking = np.maximum(now - fall * since, 0.0) + np.minimum(now + rise * since, 0.0)
        return np.asarray(np.maximum(braking @ kinematics.facets.T, problem.top_speed))


@functools.lru_cache(maxsize=64)
def _constant(steps: int, kinematics: Kinematics) -> tuple[Floats, Integers, Integers]:
    """d(u_k − u_{k−1})/du, (N·m, N·m), and −F by blocks; the rows' keys and groups."""
    m = kinematics.inputs
    changes = np.eye(steps * m) - np.eye(steps * m, k=-m)
    jacobian = np.concatenate([changes, -np.kron(np.eye(steps), kinematics.facets)])
    count = len(jacobian)
    return read_only(jacobian), read_only(np.arange(count)), read_only(np.full(count, -1))


@njit(cache=True)
def _bounds(limits: InputBounds, now: Floats, steps: int, step: float, tick: float) -> InputBounds:
    """Bounds at each step from those per second; they open where ``now`` (m,) exceeds them."""
    m = len(now)
    low, high = np.empty((steps, m)), np.empty((steps, m))
    rise, fall = np.empty((steps, m)), np.empty((steps, m))
    for k in range(steps):
        time = tick if k == 0 else step
        since = tick + k * step
        for i in range(m):
            high[k, i] = max(limits.high[i], now[i] - limits.fall[i] * since)
            low[k, i] = min(limits.low[i], now[i] + limits.rise[i] * since)
            rise[k, i] = limits.rise[i] * time
            fall[k, i] = limits.fall[i] * time
    return InputBounds(low, high, rise, fall)


@njit(cache=True)
def _rows(
    limits: InputBounds, now: Floats, inputs: Floats, step: float, tick: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """(margin, upper) of each change and (lowest, highest) change of each input, (N·m,) each."""
    steps, m = inputs.shape
    bounds = _bounds(limits, now, steps, step, tick)
    margin, upper = np.empty(steps * m), np.empty(steps * m)
    lowest, highest = np.empty(steps * m), np.empty(steps * m)
    for k in range(steps):
        for i in range(m):
            at = k * m + i
            change = inputs[k, i] - (inputs[k - 1, i] if k > 0 else now[i])
            margin[at] = change + bounds.fall[k, i]
            upper[at] = bounds.rise[k, i] - change
            lowest[at] = bounds.low[k, i] - inputs[k, i]
            highest[at] = bounds.high[k, i] - inputs[k, i]
    return margin, upper, lowest, highest
