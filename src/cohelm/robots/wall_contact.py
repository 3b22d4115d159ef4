"""Gaps between a robot's discs and walls, for compiled code."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.kernels import CACHED, callee
from cohelm.maps import DistanceField
from cohelm.maps.distance import sample


class WallGrid(NamedTuple):
    """A distance field for compiled code."""

    distance: Floats32
    """(rows, cols) m."""
    resolution: float
    """m."""
    X_MG: Floats
    """(3,)."""


def wall_grid(walls: DistanceField) -> WallGrid:
    """The arrays of a distance field."""
    return WallGrid(walls.distance, walls.resolution, walls.X_MG)


@callee()
def wall_gap(disc: Floats, pose: Floats, walls: WallGrid) -> float:
    """Gap between a disc (x, y, radius) of a robot at ``pose`` and the nearest wall, m."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x = pose[0] + cos * disc[0] - sin * disc[1]
    y = pose[1] + sin * disc[0] + cos * disc[1]
    gap: float = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0] - disc[2]
    return gap


@callee()
def circumscribed(discs: Floats) -> float:
    """Radius about the pose that holds all discs (c, 3), and the capsule with them, m."""
    around = 0.0
    for j in range(discs.shape[0]):
        around = max(around, math.hypot(discs[j, 0], discs[j, 1]) + discs[j, 2])
    return around


@njit(**CACHED)
def wall_margins(discs: Floats, pose: Floats, walls: WallGrid, margin: float) -> Floats:
    """Contact gap of each disc (c,), m: reduced for a robot that starts closer to a wall."""
    out = np.empty(discs.shape[0])
    for j in range(discs.shape[0]):
        out[j] = min(margin, wall_gap(discs[j], pose, walls) - 1e-6)
    return out
