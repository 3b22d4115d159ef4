"""Candidate trajectories, and their homotopy classes: the side of each person and of the path."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.sampling.path_samples import SPACING, PathSamples

_NEAR = 3.0
"""A person who is never nearer than this is not passed, m."""
_SWEPT = 0.7
"""A person whose bearing turns by less than this is not passed, rad."""
_SLACK = 1e-6
_BESIDE = 0.35
"""A trajectory that leaves the path by this passes an obstacle, m."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CandidateTrajectories:
    """Sampled motions over the whole horizon, best first; a record of the inner loop."""

    step: float
    """Between states, s."""
    inputs: Annotated[Floats, Shape("k N m")]
    poses: Annotated[Floats, Shape("k N+1 3")]
    score: Annotated[Floats, Shape("k")]
    """Cost of each, s of lost time with all other costs; less is better."""
    contact: Annotated[Floats, Shape("k")]
    """Time when a body (of any credible hypothesis) or a wall is first touched, s; +inf: never."""
    homotopy: Annotated[Integers, Shape("k passed")]
    """Homotopy class of each: first the side of the path (1 left, −1 right, 0 along), then the
    turn of the bearing to each person during the passage (1 counter-clockwise: the robot stays to
    the right of the person, −1 to the left, 0 no passage)."""

    def __len__(self) -> int:
        """Number of trajectories."""
        return len(self.score)


@njit(cache=True)
def homotopy_classes(poses: Floats, positions: Floats, path: PathSamples) -> Integers:
    """(k, 1 + n) as ``CandidateTrajectories.homotopy``.

    poses: (k, N+1, 3).  positions: (n, N+1, 2) of people.
    """
    out = np.zeros((poses.shape[0], 1 + positions.shape[0]), np.int64)
    for w in range(poses.shape[0]):
        out[w, 0] = _side_of_path(poses[w], path.samples)
        for i in range(positions.shape[0]):
            out[w, 1 + i] = _turn_of_bearing(poses[w], positions[i])
    return out


@njit(cache=True)
def _side_of_path(poses: Floats, samples: Floats) -> int:
    most = 0.0
    at, last = 0, samples.shape[0] - 1
    for k in range(poses.shape[0]):
        dx, dy = poses[k, 0] - samples[at, 0], poses[k, 1] - samples[at, 1]
        while at < last and dx * samples[at, 2] + dy * samples[at, 3] > SPACING:
            at += 1
            dx, dy = poses[k, 0] - samples[at, 0], poses[k, 1] - samples[at, 1]
        side = samples[at, 2] * dy - samples[at, 3] * dx
        if abs(side) > abs(most):
            most = side
    return int(math.copysign(1.0, most)) if abs(most) > _BESIDE else 0


@njit(cache=True)
def _turn_of_bearing(poses: Floats, positions: Floats) -> int:
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
