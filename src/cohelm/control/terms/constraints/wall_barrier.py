"""Barrier on walls and objects: the distance field at the discs of the footprint."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Trajectory
from cohelm.control.terms.constraints import barrier
from cohelm.maps.distance import sample
from cohelm.robots.contact import WallGrid, wall_grid

_NEAR = 0.25
"""Walls do not move, so rows with g above this stay inactive in one linearisation, m."""


class WallBarrier:
    """h = distance(c_j) − r_j − clearance for every disc j of the footprint."""

    class Parameters(Model):
        """Barrier and weights; assumed."""

        gamma: float = Field(0.3, gt=0.0, le=1.0)
        """γ of eq. (9)."""
        l1: float = Field(60.0, ge=0.0)
        """Weight of the slack, 1/m per disc."""
        l2: float = Field(60.0, ge=0.0)
        """Weight of the squared slack, 1/m² per disc."""

    name = "wall_clearance"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2

    def values(self, problem: LocalProblem, trajectory: Trajectory) -> ConstraintValues:
        """Largest violation by disc, over steps, (c,)."""
        discs, clearance = problem.robot.discs, problem.profile.clearance
        walls, gamma = wall_grid(problem.walls), self.parameters.gamma
        layout = barrier.separate_slacks(len(discs))
        slack, smallest, h, gradient = _values(
            discs, clearance, trajectory.poses, walls, gamma, layout
        )
        return ConstraintValues(slack=slack, smallest=smallest, h=h, gradient=gradient)

    def rows(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        sensitivity: Floats,
        values: ConstraintValues,
    ) -> ConstraintRows:
        """The rows that can become active."""
        del trajectory
        gamma, layout = self.parameters.gamma, barrier.separate_slacks(len(problem.robot.discs))
        rows = barrier.linearise_dcbf(values.h, values.gradient, sensitivity, gamma, _NEAR, layout)
        return barrier.constraint_rows(rows, layout, values.h.shape[1])


@njit(cache=True)
def _values(
    discs: Floats,
    clearance: float,
    poses: Floats,
    walls: WallGrid,
    gamma: float,
    layout: barrier.BarrierLayout,
) -> tuple[Floats, float, Floats, Floats]:
    """(slack, smallest, h, gradient) of ``ConstraintValues``."""
    h, gradient = wall_barrier(discs, clearance, poses, walls)
    slack, smallest = barrier.largest_violations(h, gamma, layout)
    return slack, smallest, h, gradient


@njit(cache=True)
def wall_barrier(
    discs: Floats, clearance: float, poses: Floats, walls: WallGrid
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
            x, y = poses[k, 0] + ax, poses[k, 1] + ay
            d, gx, gy = sample(walls.distance, walls.resolution, walls.X_MG, x, y)
            h[j, k] = d - discs[j, 2] - clearance
            gradient[j, k, 0] = gx
            gradient[j, k, 1] = gy
            gradient[j, k, 2] = -gx * ay + gy * ax
    return h, gradient
