"""Configuration space of the robot: free poses, free motions and their cost."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats, Floats32, Integers
from cohelm.kernels import callee
from cohelm.maps.distance import sample
from cohelm.planning.path_refinement.footprint import (
    FootprintModel,
    clear_within,
    overlaps,
    overlaps_along,
)
from cohelm.planning.path_refinement.smoothing import curvature_of

_ORIGIN = np.zeros(3)


class ConfigurationSpace(NamedTuple):
    """Footprint, weights and limits of the robot on a map; for kernels."""

    footprint: FootprintModel
    """Footprint that the line must keep free."""
    grown: FootprintModel
    """Slightly larger footprint that the search keeps free."""
    weights: Floats32
    """Packed weights of the whole grid, (rows + 2, cols + 2)."""
    clearance: Floats32
    """Distance of cell centres to obstacles and zones, (rows, cols), m."""
    heaviest: float
    """Upper bound of the weight of a point between cells."""
    floor: float
    """Clearance that the centre of the drive axle must keep, m."""
    radius: float
    """Blocked cells with a clearance above this are closed by a rule, m."""
    curvature: float
    """Largest curvature that the robot can drive, 1/m."""


def fits_at_some_heading(space: ConfigurationSpace, x: float, y: float) -> bool:
    """Check that the footprint is free at a point for one of 64 headings."""
    turn = 2.0 * math.pi / 64
    return any(not overlaps(space.footprint, x, y, k * turn) for k in range(64))


def infeasible_points(space: ConfigurationSpace, points: Floats, pivots: Integers) -> Booleans:
    """True (n,) where the footprint overlaps an obstacle or a line (n, 2) bends too much.

    At the indices ``pivots`` the robot turns on the spot, so the line may bend.
    """
    points = np.array(points)  # can be written to: the type of array that other kernels pass
    bends = curvature_of(points) > space.curvature * (1.0 + 1e-6)
    bends[pivots] = False
    return overlaps_along(space.footprint, points) | bends


@callee()
def centre_is_free(space: ConfigurationSpace, x: float, y: float) -> bool:
    """Check that the centre of the drive axle may be at a point, without the footprint."""
    footprint = space.footprint
    rows, cols = footprint.clearance.shape
    r, c = math.floor(y / footprint.resolution), math.floor(x / footprint.resolution)
    if not (0 <= r < rows and 0 <= c < cols):
        return False
    if space.weights[r + 1, c + 1] == np.inf and space.clearance[r, c] > space.radius:
        return False
    clearance, _, _ = sample(space.clearance, footprint.resolution, _ORIGIN, x, y)
    return clearance >= space.floor


@callee()
def weight_at(space: ConfigurationSpace, x: float, y: float) -> float:
    """Weight at a point; ∞ where the centre of the drive axle must not be."""
    if not centre_is_free(space, x, y):
        return np.inf
    res = space.footprint.resolution
    weight = np.float64(space.weights[math.floor(y / res) + 1, math.floor(x / res) + 1])
    return min(weight, space.heaviest)


@callee()
def motion_is_free(space: ConfigurationSpace, a: Floats, b: Floats) -> bool:
    """Check that the grown footprint is free between a free pose and another one step away."""
    footprint = space.grown
    length = math.hypot(b[0] - a[0], b[1] - a[1])
    # Far from everything, and the end pose: the cheap tests first.
    if clear_within(footprint, b[0], b[1], length):
        return True
    if overlaps(footprint, b[0], b[1], b[2]):
        return False
    # The chord of an arc, in its own direction at both ends.
    turn = b[2] - a[2]
    along = math.atan2(b[1] - a[1], b[0] - a[0])
    if abs(turn) > 1e-9 and (
        overlaps(footprint, a[0], a[1], along) or overlaps(footprint, b[0], b[1], along)
    ):
        return False
    # Poses between, less than half a cell apart.
    count = math.ceil(2.0 * (length + abs(turn) * footprint.reach) / footprint.resolution)
    for k in range(1, count):
        t = k / count
        if overlaps(footprint, a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * turn):
            return False
    return True
