"""Change inputs gently: a weight on u_k − u_{k−1}, from what the wheels do now on."""

from __future__ import annotations

import functools
import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.costs.per_input import per_input


class SmoothInput:
    """Accelerations, so that the ride is smooth and neighbouring plans agree."""

    class Parameters(Model):
        """Weights of ½‖r‖²; the paper gives none, these are assumed."""

        speed: float = Field(0.08, ge=0.0)
        """Of the linear acceleration, 1/(m/s²)² a second."""
        turn: float = Field(0.04, ge=0.0)
        """Of the angular acceleration, 1/(rad/s²)² a second."""

    name = "smooth_input"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self._root_speed, self._root_turn = math.sqrt(p.speed), math.sqrt(p.turn)

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(N·m,)."""
        return _changes(motion.inputs, motion.last_input, self._roots(problem, motion))

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``; H is tridiagonal by blocks and always the same."""
        del sensitivity
        scale = tuple(self._roots(problem, motion).tolist())
        jacobian, hessian = _differences(scale, len(motion.inputs))
        return hessian, self.residual(problem, motion) @ jacobian

    def _roots(self, problem: LocalProblem, motion: Motion) -> Floats:
        share = math.sqrt(motion.step)
        return per_input(problem.robot.motion, self._root_speed, self._root_turn, over=share)


@njit(cache=True)
def _changes(inputs: Floats, now: Floats, roots: Floats) -> Floats:
    """Changes of inputs (N, m), the first from ``now`` (m,), scaled by ``roots`` (m,); (N·m,)."""
    steps, m = inputs.shape
    out = np.empty(steps * m)
    for k in range(steps):
        for i in range(m):
            before = inputs[k - 1, i] if k > 0 else now[i]
            out[k * m + i] = (inputs[k, i] - before) * roots[i]
    return out


@functools.lru_cache(maxsize=64)
def _differences(scale: tuple[float, ...], steps: int) -> tuple[Floats, Floats]:
    """(J, H), (N·m, N·m) each, of scaled changes."""
    m, size = len(scale), len(scale) * steps
    jacobian = np.tile(scale, steps)[:, None] * (np.eye(size) - np.eye(size, k=-m))
    return jacobian, jacobian.T @ jacobian
