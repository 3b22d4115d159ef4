"""Get on along the reference: its pace counts in its own direction, wherever the robot is."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.costs.absent import absent
from cohelm.control.costs.gauss_newton import gauss_newton


class Progress:
    """What the robot gains along the reference in each step, against what the reference gains.

    r_k = √w (p_{k+1} − p_k − p̂_{k+1} + p̂_k)·t̂_k, with t̂_k the reference's direction: going round
    somebody costs what it delays, and nothing for the distance from the reference. ``InputEffort``
    asks for the same speed, but in any direction: driving in circles satisfies that.
    """

    class Parameters(Model):
        """Weight of ½‖r‖²; assumed."""

        pace: float = Field(0.0, ge=0.0)
        """Of the speed along the reference, 1/(m/s)² a second."""

    name = "progress"

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(N,), none without a weight."""
        if not self.parameters.pace:
            return np.empty(0)
        behind = motion.poses[:, :2] - problem.reference.poses[:, :2]
        gained = np.diff(behind, axis=0) * self._direction(problem, motion)
        return np.asarray(gained.sum(axis=1))

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``."""
        if not self.parameters.pace:
            return absent(motion.inputs.size)
        step = np.diff(sensitivity[:, :2], axis=0)
        jacobian = np.einsum("kac,ka->kc", step, self._direction(problem, motion))
        return gauss_newton(self.residual(problem, motion), jacobian)

    def _direction(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(N, 2) √w t̂ / Δt."""
        heading = problem.reference.poses[:-1, 2]
        unit = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        return unit * math.sqrt(self.parameters.pace / motion.step)
