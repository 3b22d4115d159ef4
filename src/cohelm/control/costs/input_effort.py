"""Keep to the wanted speed and turn little: the input cost of Xu et al., eq. (12)."""

from __future__ import annotations

import functools
import math
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion


class InputEffort:
    """(u − û)ᵀ Q_u (u − û), where û is the reference's speed without turning.

    As printed the inputs themselves are penalised (û = 0): the chair then lags behind its
    reference, and where reversing is allowed it can become the cheapest answer to a barrier.
    """

    class Parameters(Model):
        """Weights of ½‖r‖²; the paper gives none, these are assumed."""

        input_cost: Literal["reference", "printed"] = "reference"
        """What inputs are measured against: the reference's speed, or 0 as printed."""
        speed: float = Field(0.8, ge=0.0)
        """1/(m/s)² a second."""
        turn: float = Field(0.25, ge=0.0)
        """1/(rad/s)² a second."""

    name = "input_effort"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self._roots = np.sqrt([p.speed, p.turn])

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(N·m,)."""
        wanted = np.zeros_like(motion.inputs)
        if self.parameters.input_cost == "reference":
            wanted[:, 0] = problem.reference.speeds[:-1]
        return ((motion.inputs - wanted) * (self._roots * math.sqrt(motion.step))).ravel()

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``; H is diagonal and always the same."""
        del sensitivity
        roots = self._roots * math.sqrt(motion.step)
        gradient = self.residual(problem, motion).reshape(motion.inputs.shape) * roots
        return _diagonal(tuple(roots.tolist()), len(motion.inputs)), gradient.ravel()


@functools.lru_cache(maxsize=64)
def _diagonal(roots: tuple[float, ...], steps: int) -> Floats:
    """H, (N·m, N·m)."""
    return np.diag(np.tile(np.square(roots), steps))
