"""Follow the reference's poses: (x − x̂)ᵀ Q_s (x − x̂), Xu et al., eq. (12)."""

from __future__ import annotations

import functools

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.costs.gauss_newton import pose_model


class TrackReference:
    """Position and heading errors at steps 1…N; the last one weighs more (terminal cost J_N).

    As printed the distance counts alike in every direction. With ``along`` below 1 being late on
    the reference is cheaper than being beside it: who waited for somebody owes nothing for it.
    """

    class Parameters(Model):
        """Weights of ½‖r‖²; the paper gives none, these are assumed."""

        position: float = Field(1.0, ge=0.0)
        """Of the distance to the reference, 1/m² a second."""
        along: float = Field(1.0, ge=0.0, le=1.0)
        """Share of that weight which counts along the reference; 1 as printed."""
        heading: float = Field(0.3, ge=0.0)
        """Of the heading error, 1/rad² a second."""
        terminal: float = Field(4.0, ge=0.0)
        """How many seconds' worth the last state adds."""

    name = "track_reference"

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(3N,): error of position, in two directions, and heading of each step."""
        return (self._error(problem, motion) * self._scale(motion)).ravel()

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``."""
        if self.parameters.along != 1.0:
            sensitivity = _aligned(sensitivity, problem.reference.poses[:, 2])
        return pose_model(self._error(problem, motion), self._scale(motion) ** 2, sensitivity)

    def _error(self, problem: LocalProblem, motion: Motion) -> Floats:
        """(N, 3); along and across the reference where these do not count alike."""
        error = motion.poses[1:] - problem.reference.poses[1:]
        if self.parameters.along == 1.0:
            return error
        return _aligned(error[:, :, None], problem.reference.poses[1:, 2])[:, :, 0]

    def _scale(self, motion: Motion) -> Floats:
        p = self.parameters
        weights = (p.position * p.along, p.position, p.heading)
        return _roots(weights, p.terminal, len(motion.inputs), motion.step)


@functools.lru_cache(maxsize=64)
def _roots(weights: tuple[float, float, float], terminal: float, steps: int, step: float) -> Floats:
    """Square roots of the weights, (steps, 3)."""
    duration = np.full(steps, step)
    duration[-1] += terminal
    roots: Floats = np.sqrt(duration[:, None] * np.array(weights))
    return roots


@njit(cache=True)
def _aligned(columns: Floats, headings: Floats) -> Floats:
    """(k, 3, c) vectors (x, y, heading) turned into frames of ``headings`` (k,)."""
    out = np.empty_like(columns)
    for k in range(columns.shape[0]):
        cos, sin = np.cos(headings[k]), np.sin(headings[k])
        for j in range(columns.shape[2]):
            out[k, 0, j] = cos * columns[k, 0, j] + sin * columns[k, 1, j]
            out[k, 1, j] = -sin * columns[k, 0, j] + cos * columns[k, 1, j]
            out[k, 2, j] = columns[k, 2, j]
    return out
