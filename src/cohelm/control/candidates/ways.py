"""Ways round, and what tells two of them apart: on which side each person and the path lie."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.candidates.scene import SPACING, Road

_NEAR = 3.0
"""Who is never nearer than this is not passed, m."""
_SWEPT = 0.7
"""Nor who is passed without the bearing to him turning by this, rad."""
_SLACK = 1e-6
_BESIDE = 0.35
"""A way that leaves the path by this leads round something, m."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ways:
    """Sampled motions over the whole lookahead, best first; a record of the inner loop."""

    step: float
    """Between states, s."""
    inputs: Annotated[Floats, Shape("k N m")]
    poses: Annotated[Floats, Shape("k N+1 3")]
    score: Annotated[Floats, Shape("k")]
    """What each costs, s of time lost and all else in its terms; less is better."""
    contact: Annotated[Floats, Shape("k")]
    """When a body (of any credible future) or a wall is first touched, s; +inf: never."""
    signature: Annotated[Integers, Shape("k passed")]
    """How each passes: first the side of the path on which it leads (1 left, −1 right, 0 along),
    then how the bearing to each person turns as they pass each other (1 counter-clockwise: the
    robot keeps to the right of them, −1 to the left, 0 not at all)."""

    def __len__(self) -> int:
        """How many."""
        return len(self.score)


@njit(cache=True)
def signatures(poses: Floats, positions: Floats, road: Road) -> Integers:
    """(k, 1 + n) as ``Ways.signature``, of poses (k, N+1, 3) among people at (n, N+1, 2)."""
    out = np.zeros((poses.shape[0], 1 + positions.shape[0]), np.int64)
    for w in range(poses.shape[0]):
        out[w, 0] = _side_of_path(poses[w], road)
        for i in range(positions.shape[0]):
            out[w, 1 + i] = _turn_of_bearing(poses[w], positions[i])
    return out


@njit(cache=True)
def _side_of_path(poses: Floats, road: Road) -> int:
    most = 0.0
    at, last = 0, road.samples.shape[0] - 1
    for k in range(poses.shape[0]):
        dx, dy = poses[k, 0] - road.samples[at, 0], poses[k, 1] - road.samples[at, 1]
        while at < last and dx * road.samples[at, 2] + dy * road.samples[at, 3] > SPACING:
            at += 1
            dx, dy = poses[k, 0] - road.samples[at, 0], poses[k, 1] - road.samples[at, 1]
        side = road.samples[at, 2] * dy - road.samples[at, 3] * dx
        if abs(side) > abs(most):
            most = side
    return int(math.copysign(1.0, most)) if abs(most) > _BESIDE else 0


@njit(cache=True)
def _turn_of_bearing(poses: Floats, positions: Floats) -> int:
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
