"""Candidate trajectories, and the sides on which they pass people and the path.

The vector of these sides approximates the homotopy class: trajectories of one class agree in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.path import SPACING, PathTable
from cohelm.kernels import CACHED

_NEAR = 3.0
"""A person who is never nearer than this is not passed, m."""
_SWEPT = 0.7
"""A person whose bearing turns by less than this is not passed, rad."""
_SLACK = 1e-6
_BESIDE = 0.35
"""A trajectory that leaves the path by this passes an obstacle, m."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CandidateTrajectories:
    """Trajectories over the whole horizon, in the order of their source; unchecked."""

    step: float
    """Between states, s."""
    inputs: Annotated[Floats, Shape("k N m")]
    poses: Annotated[Floats, Shape("k N+1 3")]
    cost: Annotated[Floats, Shape("k")]
    """Objective, s: lost time, and all other costs in the same unit."""
    by_term: Annotated[Floats, Shape("k T")]
    """Summands of the cost, ``objective.TERMS`` and terms of one's own."""
    slack: Annotated[Floats, Shape("k")]
    """Largest violation of a barrier, m."""
    passing_sides: Annotated[Integers, Shape("k passed")]
    """Signs: first the side of the path (1 left, −1 right, 0 along), then the turn of the bearing
    to each person during the passage (1 counter-clockwise: the robot stays to the right of the
    person, −1 to the left, 0 no passage)."""

    def __len__(self) -> int:
        """Number of trajectories."""
        return len(self.cost)

    def __getitem__(self, chosen: Integers) -> CandidateTrajectories:
        """Some of the trajectories."""
        return CandidateTrajectories(
            step=self.step,
            inputs=self.inputs[chosen],
            poses=self.poses[chosen],
            cost=self.cost[chosen],
            by_term=self.by_term[chosen],
            slack=self.slack[chosen],
            passing_sides=self.passing_sides[chosen],
        )


@njit(**CACHED)
def passing_sides(poses: Floats, positions: Floats, path: PathTable) -> Integers:
    """(k, 1 + n) as ``CandidateTrajectories.passing_sides``.

    poses: (k, N+1, 3).  positions: (n, N+1, 2) of people.
    """
    out = np.zeros((poses.shape[0], 1 + positions.shape[0]), np.int64)
    for w in range(poses.shape[0]):
        out[w, 0] = _side_of_path(poses[w], path.samples)
        for i in range(positions.shape[0]):
            out[w, 1 + i] = _turn_of_bearing(poses[w], positions[i])
    return out


@njit(**CACHED)
def _side_of_path(poses: Floats, samples: Floats) -> int:
    """Side of the largest lateral distance from the path; 0 if that is small."""
    largest = 0.0
    i, last = 0, samples.shape[0] - 1
    for k in range(poses.shape[0]):
        dx, dy = poses[k, 0] - samples[i, 0], poses[k, 1] - samples[i, 1]
        while i < last and dx * samples[i, 2] + dy * samples[i, 3] > SPACING:
            i += 1
            dx, dy = poses[k, 0] - samples[i, 0], poses[k, 1] - samples[i, 1]
        d = samples[i, 2] * dy - samples[i, 3] * dx
        if abs(d) > abs(largest):
            largest = d
    return int(math.copysign(1.0, largest)) if abs(largest) > _BESIDE else 0


@njit(**CACHED)
def _turn_of_bearing(poses: Floats, positions: Floats) -> int:
    """Sign of the turn of the bearing from the robot to a person; 0 if nobody is passed."""
    # without square roots first: most people are far away
    square = np.inf
    for k in range(1, poses.shape[0]):
        u, v = positions[k, 0] - poses[k, 0], positions[k, 1] - poses[k, 1]
        square = min(square, u * u + v * v)
    if square > _NEAR * _NEAR + _SLACK:
        return 0
    turned, nearest = 0.0, np.inf
    x, y = positions[0, 0] - poses[0, 0], positions[0, 1] - poses[0, 1]
    for k in range(1, poses.shape[0]):
        u, v = positions[k, 0] - poses[k, 0], positions[k, 1] - poses[k, 1]
        turned += math.atan2(x * v - y * u, x * u + y * v)
        nearest = min(nearest, math.hypot(u, v))
        x, y = u, v
    return int(math.copysign(1.0, turned)) if nearest < _NEAR and abs(turned) > _SWEPT else 0
