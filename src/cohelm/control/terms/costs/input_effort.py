"""Input cost of Xu et al., eq. (12): speed of the reference, little turning."""

from __future__ import annotations

import functools
import math
from typing import Literal

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.terms.costs.gauss_newton import gauss_newton, per_input


class InputEffort:
    """(u − û)ᵀ Q_u (u − û), where û is the reference's speed without turning.

    A holonomic robot is to have that speed in the reference's direction, whatever its own heading.
    As printed the inputs themselves are penalised (û = 0): the chair then lags behind its
    reference, and where reversing is allowed it can become the cheapest answer to a barrier.
    """

    class Parameters(Model):
        """Weights of ½‖r‖²; the paper gives none, these are assumed."""

        input_cost: Literal["reference", "printed"] = "reference"
        """Desired input û: the reference's speed, or 0 as printed."""
        speed: float = Field(0.8, ge=0.0)
        """Weight of the speed, 1/(m/s)² per second."""
        turn: float = Field(0.25, ge=0.0)
        """Weight of the turn rate, 1/(rad/s)² per second."""

    name = "input_effort"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self._root_speed, self._root_turn = math.sqrt(p.speed), math.sqrt(p.turn)

    def residual(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """(N·m,)."""
        roots = self._roots(problem, trajectory)
        if self.parameters.input_cost == "printed":
            return (trajectory.inputs * roots).ravel()
        speeds = problem.reference.speeds
        if problem.robot.motion_model.translating == 1:
            return _speed_residual(trajectory.inputs, speeds, roots)
        heading_error, difference = _heading_error(problem, trajectory), trajectory.inputs.copy()
        difference[:, 0] -= speeds[:-1] * np.cos(heading_error)
        difference[:, 1] -= speeds[:-1] * np.sin(heading_error)
        difference *= roots
        return difference.ravel()

    def model(
        self, problem: LocalProblem, trajectory: Trajectory, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``; H is constant and diagonal where headings do not matter."""
        residual, roots = self.residual(problem, trajectory), self._roots(problem, trajectory)
        steps, m = trajectory.inputs.shape
        n_linear = problem.robot.motion_model.translating
        if n_linear == 1 or self.parameters.input_cost == "printed":
            gradient = residual.reshape(steps, m) * roots
            return _diagonal(tuple(roots.tolist()), steps), gradient.ravel()
        # û in the robot frame depends on the robot's heading: ∂û/∂θ = s (sin, −cos)(θ̂ − θ)
        heading_error, speeds = _heading_error(problem, trajectory), problem.reference.speeds[:-1]
        jacobian = np.diag(np.tile(roots, steps))
        turns = sensitivity[:-1, 2]
        jacobian[0::m] -= (roots[0] * speeds * np.sin(heading_error))[:, None] * turns
        jacobian[1::m] += (roots[1] * speeds * np.cos(heading_error))[:, None] * turns
        return gauss_newton(residual, jacobian)

    def _roots(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        share = math.sqrt(trajectory.step)
        return per_input(problem.robot.motion_model, self._root_speed, self._root_turn, share)


@njit(cache=True)
def _speed_residual(inputs: Floats, speeds: Floats, roots: Floats) -> Floats:
    """Inputs (N, m) minus the speeds (N+1,) of the reference, scaled by ``roots`` (m,); (N·m,)."""
    steps, m = inputs.shape
    out = np.empty(steps * m)
    for k in range(steps):
        for i in range(m):
            reference = speeds[k] if i == 0 else 0.0
            out[k * m + i] = (inputs[k, i] - reference) * roots[i]
    return out


def _heading_error(problem: LocalProblem, trajectory: Trajectory) -> Floats:
    """θ̂ − θ of each step, (N,)."""
    return np.asarray(problem.reference.poses[:-1, 2] - trajectory.poses[:-1, 2])


@functools.lru_cache(maxsize=64)
def _diagonal(roots: tuple[float, ...], steps: int) -> Floats:
    """H, (N·m, N·m)."""
    return np.diag(np.tile(np.square(roots), steps))
