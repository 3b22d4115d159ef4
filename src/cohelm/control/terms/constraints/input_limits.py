"""Limits of speed and acceleration: the set U of Xu et al., eq. (11)."""

from __future__ import annotations

import functools

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Integers, read_only
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Trajectory
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

    def values(self, problem: LocalProblem, trajectory: Trajectory) -> ConstraintValues:
        """Return no values: these bounds are hard, and no barrier."""
        del problem, trajectory
        return _NOTHING

    def rows(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        sensitivity: Floats,
        values: ConstraintValues,
    ) -> ConstraintRows:
        """Rows for rise and fall of every input at every step and for the facets; input bounds."""
        del sensitivity, values
        kinematics = problem.robot.motion_model
        jacobian, row_id, no_slack = _constant(len(trajectory.inputs), kinematics)
        margin, upper, low, high = _rows(
            problem.input_bounds(),
            trajectory.current_input,
            trajectory.inputs,
            trajectory.step,
            self.parameters.tick,
        )
        if len(kinematics.facets):
            excess = trajectory.inputs @ kinematics.facets.T
            slower = (self.top_speeds(problem, trajectory) - excess).ravel()
            margin = np.concatenate([margin, slower])
            upper = np.concatenate([upper, np.full(len(slower), _FAR)])
        return ConstraintRows(
            margin=margin,
            jacobian=jacobian,
            slack_index=no_slack,
            row_id=row_id,
            num_row_ids=len(row_id),
            upper=upper,
            low=low,
            high=high,
        )

    def bounds(self, problem: LocalProblem, trajectory: Trajectory) -> InputBounds:
        """Bounds of each input at each step, (N, m) each; rise and fall within the step."""
        limits, tick = problem.input_bounds(), self.parameters.tick
        return _bounds(
            limits, trajectory.current_input, len(trajectory.inputs), trajectory.step, tick
        )

    def top_speeds(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """Bounds on F u of each facet at each step, (N, f): the top speed, or braking to it."""
        kinematics, current_input = problem.robot.motion_model, trajectory.current_input
        _, _, rise, fall = problem.input_bounds()
        since = self.parameters.tick + trajectory.step * np.arange(len(trajectory.inputs))[:, None]
        braking = np.maximum(current_input - fall * since, 0.0) + np.minimum(
            current_input + rise * since, 0.0
        )
        return np.asarray(np.maximum(braking @ kinematics.facets.T, problem.top_speed))


@functools.lru_cache(maxsize=64)
def _constant(steps: int, kinematics: Kinematics) -> tuple[Floats, Integers, Integers]:
    """d(u_k − u_{k−1})/du, (N·m, N·m), and −F by blocks; ids and slack indices of the rows."""
    m = kinematics.inputs
    changes = np.eye(steps * m) - np.eye(steps * m, k=-m)
    jacobian = np.concatenate([changes, -np.kron(np.eye(steps), kinematics.facets)])
    count = len(jacobian)
    return read_only(jacobian), read_only(np.arange(count)), read_only(np.full(count, -1))


@njit(cache=True)
def _bounds(
    limits: InputBounds, current_input: Floats, steps: int, step: float, tick: float
) -> InputBounds:
    """Bounds at each step, (N, m) each, from those per second.

    They open where ``current_input`` (m,) exceeds them.
    """
    m = len(current_input)
    low, high = np.empty((steps, m)), np.empty((steps, m))
    rise, fall = np.empty((steps, m)), np.empty((steps, m))
    for k in range(steps):
        time = tick if k == 0 else step
        since = tick + k * step
        for i in range(m):
            high[k, i] = max(limits.high[i], current_input[i] - limits.fall[i] * since)
            low[k, i] = min(limits.low[i], current_input[i] + limits.rise[i] * since)
            rise[k, i] = limits.rise[i] * time
            fall[k, i] = limits.fall[i] * time
    return InputBounds(low, high, rise, fall)


@njit(cache=True)
def _rows(
    limits: InputBounds, current_input: Floats, inputs: Floats, step: float, tick: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """(margin, upper) of each change and (lowest, highest) change of each input, (N·m,) each."""
    steps, m = inputs.shape
    bounds = _bounds(limits, current_input, steps, step, tick)
    margin, upper = np.empty(steps * m), np.empty(steps * m)
    lowest, highest = np.empty(steps * m), np.empty(steps * m)
    for k in range(steps):
        for i in range(m):
            at = k * m + i
            change = inputs[k, i] - (inputs[k - 1, i] if k > 0 else current_input[i])
            margin[at] = change + bounds.fall[k, i]
            upper[at] = bounds.rise[k, i] - change
            lowest[at] = bounds.low[k, i] - inputs[k, i]
            highest[at] = bounds.high[k, i] - inputs[k, i]
    return margin, upper, lowest, highest
