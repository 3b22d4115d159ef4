"""What the rider feels in the seat: acceleration, forward and sideways, and its change."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.costs.absent import absent
from cohelm.control.costs.gauss_newton import gauss_newton


class Comfort:
    """Acceleration a = v̇ + ω × v of the drive axle in the robot frame, and jerk, its change.

    For a chair that is (v̇, ω v): turning at speed is felt as well as braking. ``SmoothInput``
    weighs the changes of each input alike at any speed; this one weighs what they do to the rider.
    The jerk into the first step is not known and not counted.
    """

    class Parameters(Model):
        """Weights of ½‖r‖²; assumed. Without them the term is not there."""

        acceleration: float = Field(0.0, ge=0.0)
        """1/(m/s²)² a second."""
        jerk: float = Field(0.0, ge=0.0)
        """1/(m/s³)² a second."""

    name = "comfort"

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(2N + 2(N−1),) accelerations, then jerks; those with a weight."""
        if not (self.parameters.acceleration or self.parameters.jerk):
            return np.empty(0)
        felt, _ = self._felt(problem, motion)
        return self._weighted(felt[:, :, None], motion.step)[:, 0]

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``."""
        del sensitivity
        if not (self.parameters.acceleration or self.parameters.jerk):
            return absent(motion.inputs.size)
        felt, slope = self._felt(problem, motion)
        return gauss_newton(
            self._weighted(felt[:, :, None], motion.step)[:, 0],
            self._weighted(slope, motion.step),
        )

    def _felt(self, problem: LocalProblem, motion: Motion) -> tuple[Floats, Floats]:
        over = problem.robot.motion.translating
        return _accelerations(motion.inputs, motion.last_input, motion.step, over)

    def _weighted(self, felt: Floats, step: float) -> Floats:
        """(q, c) scaled accelerations and jerks from (N, 2, c)."""
        p, columns = self.parameters, felt.shape[2]
        parts = []
        if p.acceleration:
            parts.append(math.sqrt(p.acceleration * step) * felt)
        if p.jerk:
            parts.append(math.sqrt(p.jerk / step) * np.diff(felt, axis=0))
        return np.concatenate([part.reshape(-1, columns) for part in parts])


@njit(cache=True)
def _accelerations(
    inputs: Floats, now: Floats, step: float, translating: int
) -> tuple[Floats, Floats]:
    """(a (N, 2), its derivative (N, 2, N·m) by the inputs)."""
    steps, m = inputs.shape
    turn = m - 1
    felt, slope = np.zeros((steps, 2)), np.zeros((steps, 2, steps * m))
    for k in range(steps):
        at = k * m
        w = inputs[k, turn]
        for i in range(translating):
            before = inputs[k - 1, i] if k > 0 else now[i]
            felt[k, i] += (inputs[k, i] - before) / step
            slope[k, i, at + i] += 1.0 / step
            if k > 0:
                slope[k, i, at - m + i] -= 1.0 / step
            # ω × v: what goes ahead is pushed to the left, what goes to the left backwards
            sign = 1.0 if i == 0 else -1.0
            felt[k, 1 - i] += sign * w * inputs[k, i]
            slope[k, 1 - i, at + i] += sign * w
            slope[k, 1 - i, at + turn] += sign * inputs[k, i]
    return felt, slope
