"""Smoothness: changes of the inputs, and acceleration and jerk in the seat."""

from __future__ import annotations

import functools
import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.terms.costs.gauss_newton import gauss_newton, no_cost, per_input


class SmoothInput:
    """Weight on u_k − u_{k−1}, so that the ride is smooth and successive plans agree."""

    class Parameters(Model):
        """Weights of ½‖r‖²; the paper gives none, these are assumed."""

        speed: float = Field(0.08, ge=0.0)
        """Weight of the linear acceleration, 1/(m/s²)² per second."""
        turn: float = Field(0.04, ge=0.0)
        """Weight of the angular acceleration, 1/(rad/s²)² per second."""

    name = "smooth_input"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self._root_speed, self._root_turn = math.sqrt(p.speed), math.sqrt(p.turn)

    def residual(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """(N·m,)."""
        return _changes(
            trajectory.inputs, trajectory.current_input, self._roots(problem, trajectory)
        )

    def model(
        self, problem: LocalProblem, trajectory: Trajectory, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``; H is constant and block tridiagonal."""
        del sensitivity
        scale = tuple(self._roots(problem, trajectory).tolist())
        jacobian, hessian = _differences(scale, len(trajectory.inputs))
        return hessian, self.residual(problem, trajectory) @ jacobian

    def _roots(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        share = math.sqrt(trajectory.step)
        return per_input(
            problem.robot.motion_model, self._root_speed, self._root_turn, divisor=share
        )


class SeatComfort:
    """Acceleration a = v̇ + ω × v of the drive axle in the robot frame, and its change, the jerk.

    For a chair that is (v̇, ω v): the rider feels a turn at speed as well as braking.
    ``SmoothInput`` weighs changes of the inputs independently of the speed. The jerk into the first
    step is unknown and not counted.
    """

    class Parameters(Model):
        """Weights of ½‖r‖²; assumed. The term is absent without them."""

        acceleration: float = Field(0.0, ge=0.0)
        """Weight of the acceleration, 1/(m/s²)² per second."""
        jerk: float = Field(0.0, ge=0.0)
        """Weight of the jerk, 1/(m/s³)² per second."""

    name = "comfort"

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def residual(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """(2N + 2(N−1),) accelerations, then jerks, each only with a weight."""
        if not (self.parameters.acceleration or self.parameters.jerk):
            return np.empty(0)
        acceleration, _ = self._accelerations(problem, trajectory)
        return self._weighted(acceleration[:, :, None], trajectory.step)[:, 0]

    def model(
        self, problem: LocalProblem, trajectory: Trajectory, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``."""
        del sensitivity
        if not (self.parameters.acceleration or self.parameters.jerk):
            return no_cost(trajectory.inputs.size)
        acceleration, slope = self._accelerations(problem, trajectory)
        return gauss_newton(
            self._weighted(acceleration[:, :, None], trajectory.step)[:, 0],
            self._weighted(slope, trajectory.step),
        )

    def _accelerations(
        self, problem: LocalProblem, trajectory: Trajectory
    ) -> tuple[Floats, Floats]:
        n_linear = problem.robot.motion_model.translating
        return _accelerations(
            trajectory.inputs, trajectory.current_input, trajectory.step, n_linear
        )

    def _weighted(self, acceleration: Floats, step: float) -> Floats:
        """(q, c) scaled accelerations and jerks from (N, 2, c)."""
        p, columns = self.parameters, acceleration.shape[2]
        parts = []
        if p.acceleration:
            parts.append(math.sqrt(p.acceleration * step) * acceleration)
        if p.jerk:
            parts.append(math.sqrt(p.jerk / step) * np.diff(acceleration, axis=0))
        return np.concatenate([part.reshape(-1, columns) for part in parts])


@njit(cache=True)
def _changes(inputs: Floats, current_input: Floats, roots: Floats) -> Floats:
    """Changes of inputs (N, m) from one step to the next, scaled by ``roots`` (m,); (N·m,).

    The first is the change from ``current_input`` (m,).
    """
    steps, m = inputs.shape
    out = np.empty(steps * m)
    for k in range(steps):
        for i in range(m):
            before = inputs[k - 1, i] if k > 0 else current_input[i]
            out[k * m + i] = (inputs[k, i] - before) * roots[i]
    return out


@functools.lru_cache(maxsize=64)
def _differences(scale: tuple[float, ...], steps: int) -> tuple[Floats, Floats]:
    """(J, H), (N·m, N·m) each, of scaled changes."""
    m, size = len(scale), len(scale) * steps
    jacobian = np.tile(scale, steps)[:, None] * (np.eye(size) - np.eye(size, k=-m))
    return jacobian, jacobian.T @ jacobian


@njit(cache=True)
def _accelerations(
    inputs: Floats, current_input: Floats, step: float, n_linear: int
) -> tuple[Floats, Floats]:
    """(a (N, 2), its derivative (N, 2, N·m) by the inputs)."""
    steps, m = inputs.shape
    i_turn = m - 1
    acceleration, slope = np.zeros((steps, 2)), np.zeros((steps, 2, steps * m))
    for k in range(steps):
        at = k * m
        w = inputs[k, i_turn]
        for i in range(n_linear):
            before = inputs[k - 1, i] if k > 0 else current_input[i]
            acceleration[k, i] += (inputs[k, i] - before) / step
            slope[k, i, at + i] += 1.0 / step
            if k > 0:
                slope[k, i, at - m + i] -= 1.0 / step
            # ω × v: forward motion accelerates to the left, motion to the left backwards
            sign = 1.0 if i == 0 else -1.0
            acceleration[k, 1 - i] += sign * w * inputs[k, i]
            slope[k, 1 - i, at + i] += sign * w
            slope[k, 1 - i, at + i_turn] += sign * inputs[k, i]
    return acceleration, slope
