"""Follow the reference's poses: (x − x̂)ᵀ Q_s (x − x̂), Xu et al., eq. (12)."""

from __future__ import annotations

import functools

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.costs.gauss_newton import pose_model


class TrackReference:
    """Position and heading errors at steps 1…N; the last one weighs more (terminal cost J_N)."""

    class Parameters(Model):
        """Weights of ½‖r‖²; the paper gives none, these are assumed."""

        position: float = Field(1.0, ge=0.0)
        """Of the distance to the reference, 1/m² a second."""
        heading: float = Field(0.3, ge=0.0)
        """Of the heading error, 1/rad² a second."""
        terminal: float = Field(4.0, ge=0.0)
        """How many seconds' worth the last state adds."""

    name = "track_reference"

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(3N,): x, y and heading of each step."""
        scale = self._scale(motion)
        return ((motion.poses[1:] - problem.reference.poses[1:]) * scale).ravel()

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``."""
        error = motion.poses[1:] - problem.reference.poses[1:]
        return pose_model(error, self._scale(motion) ** 2, sensitivity)

    def _scale(self, motion: Motion) -> Floats:
        p = self.parameters
        return _roots(p.position, p.heading, p.terminal, len(motion.inputs), motion.step)


@functools.lru_cache(maxsize=64)
def _roots(position: float, heading: float, terminal: float, steps: int, step: float) -> Floats:
    """Square roots of the weights, (steps, 3)."""
    duration = np.full(steps, step)
    duration[-1] += terminal
    roots: Floats = np.sqrt(duration[:, None] * np.array([position, position, heading]))
    return roots
