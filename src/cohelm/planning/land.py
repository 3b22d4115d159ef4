"""Where a robot may drive: what its footprint meets, where its centre may be, and at what price."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Floats32, Integers
from cohelm.maps.distance import sample
from cohelm.planning.footprint import Body, met_along, overlaps, roomy
from cohelm.planning.smoothing import curvature_of

_ORIGIN = np.zeros(3)


class Land(NamedTuple):
    """Where the search goes on; plain, so that kernels take it."""

    body: Body
    """What the line must keep free."""
    grown: Body
    """A little larger: what the search keeps free."""
    weights: Floats32
    """Packed, of the whole grid, (rows + 2, cols + 2)."""
    clearance: Floats32
    """(rows, cols), m: of the drive axle's centre, to obstacles and zones."""
    heaviest: float
    """What a point between cells weighs at most."""
    floor: float
    """Clearance that the drive axle's centre keeps, m."""
    radius: float
    """Cells with more clearance are blocked by something else, m."""
    curvature: float
    """The sharpest that the robot can drive, 1/m."""


def stands(land: Land, x: float, y: float) -> bool:
    """Whether the robot can stand at a point in any direction."""
    turn = 2.0 * math.pi / 64
    return any(not overlaps(land.body, x, y, k * turn) for k in range(64))


def misfits(land: Land, points: Floats, pivots: Integers) -> Booleans:
    """At which points (n,) the footprint meets something, or a line bends too much; pivots may."""
    bends = curvature_of(points) > land.curvature * (1.0 + 1e-6)
    bends[pivots] = False
    return met_along(land.body, points) | bends


@njit(cache=True)
def centre_fits(land: Land, x: float, y: float) -> bool:
    """Whether the drive axle's centre may be at a point, whatever the footprint does there."""
    body = land.body
    rows, cols = body.clearance.shape
    r, c = math.floor(y / body.resolution), math.floor(x / body.resolution)
    if not (0 <= r < rows and 0 <= c < cols):
        return False
    if land.weights[r + 1, c + 1] == np.inf and land.clearance[r, c] > land.radius:
        return False
    room, _, _ = sample(land.clearance, body.resolution, _ORIGIN, x, y)
    return room >= land.floor


@njit(cache=True)
def weight_at(land: Land, x: float, y: float) -> float:
    """The weight at a point; ∞ where the drive axle's centre must not be."""
    if not centre_fits(land, x, y):
        return np.inf
    res = land.body.resolution
    weight = np.float64(land.weights[math.floor(y / res) + 1, math.floor(x / res) + 1])
    return min(weight, land.heaviest)


@njit(cache=True)
def drives(land: Land, a: Floats, b: Floats) -> bool:
    """Whether the robot, a little larger, can drive from a pose where it fits to one a step on."""
    body = land.grown
    length = math.hypot(b[0] - a[0], b[1] - a[1])
    if roomy(body, b[0], b[1], length):
        return True
    if overlaps(body, b[0], b[1], b[2]):
        return False
    turn = b[2] - a[2]
    along = math.atan2(b[1] - a[1], b[0] - a[0])
    if abs(turn) > 1e-9 and (
        overlaps(body, a[0], a[1], along) or overlaps(body, b[0], b[1], along)
    ):
        return False
    count = math.ceil(2.0 * (length + abs(turn) * body.reach) / body.resolution)
    for k in range(1, count):
        t = k / count
        if overlaps(body, a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * turn):
            return False
    return True
