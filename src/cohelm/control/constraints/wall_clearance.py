"""Keep the footprint off walls and things: a barrier on the distance field at its discs."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Floats32
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints import barrier
from cohelm.control.constraints.series import series_rows
from cohelm.maps.distance import sample

_NEAR = 0.25
"""A wall does not move, so rows with a margin above this stay inactive in one linearisation, m."""


class WallClearance:
    """h = distance(c_j) − r_j − clearance for every disc j of the footprint."""

    class Parameters(Model):
        """Barrier and price; assumed."""

        gamma: float = Field(0.3, gt=0.0, le=1.0)
        """γ of eq. (9)."""
        l1: float = Field(60.0, ge=0.0)
        """Price of the slack, 1/m a disc."""
        l2: float = Field(60.0, ge=0.0)
        """Price of the slack squared, 1/m² a disc."""

    name = "wall_clearance"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """By disc, the worst over steps, (c,)."""
        walls = problem.walls
        return Measure(
            *_measured(
                problem.robot.discs,
                problem.profile.clearance,
                motion.poses,
                walls.distance,
                walls.resolution,
                walls.X_MG,
                self.parameters.gamma,
            )
        )

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        del problem, motion
        return series_rows(measure.h, measure.gradient, sensitivity, self.parameters.gamma, _NEAR)


@njit(cache=True)
def _measured(  # noqa: PLR0917  # a kernel takes plain arrays
    discs: Floats,
    clearance: float,
    poses: Floats,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    gamma: float,
) -> tuple[Floats, float, Floats, Floats]:
    """(slack, smallest, h, gradient) of ``Measure``."""
    h, gradient = wall_barrier(discs, clearance, poses, distance, resolution, X_MG)
    worst, smallest = barrier.worst(h, gamma)
    return worst, smallest, h, gradient


@njit(cache=True)
def wall_barrier(  # a kernel takes plain arrays
    discs: Floats,
    clearance: float,
    poses: Floats,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
) -> tuple[Floats, Floats]:
    """(h (c, N+1), gradient (c, N+1, 3)) of discs (c, 3) along poses (N+1, 3)."""
    count, states = discs.shape[0], poses.shape[0]
    h = np.empty((count, states))
    gradient = np.empty((count, states, 3))
    for k in range(states):
        cos, sin = math.cos(poses[k, 2]), math.sin(poses[k, 2])
        for j in range(count):
            ax = cos * discs[j, 0] - sin * discs[j, 1]
            ay = sin * discs[j, 0] + cos * discs[j, 1]
            d, gx, gy = sample(distance, resolution, X_MG, poses[k, 0] + ax, poses[k, 1] + ay)
            h[j, k] = d - discs[j, 2] - clearance
            gradient[j, k, 0] = gx
            gradient[j, k, 1] = gy
            gradient[j, k, 2] = -gx * ay + gy * ax
    return h, gradient
