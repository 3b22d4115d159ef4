"""Tracking of the reference: its poses, and progress along it."""

from __future__ import annotations

import functools
import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.terms.costs.gauss_newton import gauss_newton, no_cost, pose_model


class TrackReference:
    """(x − x̂)ᵀ Q_s (x − x̂), Xu et al., eq. (12), at steps 1…N; the last one weighs more (J_N).

    As printed all directions of the position error weigh the same. With ``along`` below 1 a delay
    on the reference costs less than an offset from it, for instance after waiting for a person.
    """

    class Parameters(Model):
        """Weights of ½‖r‖²; the paper gives none, these are assumed."""

        position: float = Field(1.0, ge=0.0)
        """Weight of the distance to the reference, 1/m² per second."""
        along: float = Field(1.0, ge=0.0, le=1.0)
        """Share of that weight along the reference; 1 as printed."""
        heading: float = Field(0.3, ge=0.0)
        """Weight of the heading error, 1/rad² per second."""
        terminal: float = Field(4.0, ge=0.0)
        """Additional weight of the last state, s."""

    name = "track_reference"

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def residual(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """(3N,): position error in two directions and heading error of each step."""
        return (self._error(problem, trajectory) * self._scale(trajectory)).ravel()

    def model(
        self, problem: LocalProblem, trajectory: Trajectory, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``."""
        if self.parameters.along != 1.0:
            sensitivity = _aligned(sensitivity, problem.reference.poses[:, 2])
        return pose_model(
            self._error(problem, trajectory), self._scale(trajectory) ** 2, sensitivity
        )

    def _error(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """(N, 3); along and across the reference where their weights differ."""
        error = trajectory.poses[1:] - problem.reference.poses[1:]
        if self.parameters.along == 1.0:
            return error
        return _aligned(error[:, :, None], problem.reference.poses[1:, 2])[:, :, 0]

    def _scale(self, trajectory: Trajectory) -> Floats:
        p = self.parameters
        weights = (p.position * p.along, p.position, p.heading)
        return _roots(weights, p.terminal, len(trajectory.inputs), trajectory.step)


class PathProgress:
    """Progress along the reference in each step, compared with the reference's own progress.

    r_k = √w (p_{k+1} − p_k − p̂_{k+1} + p̂_k)·t̂_k, with t̂_k the reference's direction: passing a
    person costs the delay and nothing for the distance from the reference. ``InputEffort`` wants
    the same speed in any direction, which driving in circles satisfies as well.
    """

    class Parameters(Model):
        """Weight of ½‖r‖²; assumed."""

        pace: float = Field(0.0, ge=0.0)
        """Weight of the speed along the reference, 1/(m/s)² per second."""

    name = "progress"

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def residual(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """(N,); empty without a weight."""
        if not self.parameters.pace:
            return np.empty(0)
        behind = trajectory.poses[:, :2] - problem.reference.poses[:, :2]
        gained = np.diff(behind, axis=0) * self._direction(problem, trajectory)
        return np.asarray(gained.sum(axis=1))

    def model(
        self, problem: LocalProblem, trajectory: Trajectory, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """See ``CostTerm``."""
        if not self.parameters.pace:
            return no_cost(trajectory.inputs.size)
        step = np.diff(sensitivity[:, :2], axis=0)
        jacobian = np.einsum("kac,ka->kc", step, self._direction(problem, trajectory))
        return gauss_newton(self.residual(problem, trajectory), jacobian)

    def _direction(self, problem: LocalProblem, trajectory: Trajectory) -> Floats:
        """(N, 2) √w t̂ / Δt."""
        heading = problem.reference.poses[:-1, 2]
        unit = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        return unit * math.sqrt(self.parameters.pace / trajectory.step)


@functools.lru_cache(maxsize=64)
def _roots(weights: tuple[float, float, float], terminal: float, steps: int, step: float) -> Floats:
    """Square roots of the weights, (steps, 3)."""
    duration = np.full(steps, step)
    duration[-1] += terminal
    roots: Floats = np.sqrt(duration[:, None] * np.array(weights))
    return roots


@njit(cache=True)
def _aligned(columns: Floats, headings: Floats) -> Floats:
    """(k, 3, c) vectors (x, y, heading), rotated into frames of ``headings`` (k,)."""
    out = np.empty_like(columns)
    for k in range(columns.shape[0]):
        cos, sin = np.cos(headings[k]), np.sin(headings[k])
        for j in range(columns.shape[2]):
            out[k, 0, j] = cos * columns[k, 0, j] + sin * columns[k, 1, j]
            out[k, 1, j] = -sin * columns[k, 0, j] + cos * columns[k, 1, j]
            out[k, 2, j] = columns[k, 2, j]
    return out
