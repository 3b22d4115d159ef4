"""Which directions are free: where the ground was seen and nothing stood before it."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats

DIRECTIONS = 360


@njit(cache=True)
def free_ends(points: Floats, ground: Booleans, columns: Floats) -> Floats:
    """The farthest ground seen in each direction in which no column stands, (k, 2), m.

    A direction without ground is not told: nothing came back from it, and a cloud cannot say
    whether it is free or the sensor blind there.

    Args:
        points: (p, 3) from the sensor, m.
        ground: (p,) which are ground.
        columns: (q, 2) from the sensor, m.
    """
    stands = np.zeros(DIRECTIONS, dtype=np.bool_)
    for i in range(columns.shape[0]):
        stands[_direction(columns[i, 0], columns[i, 1])] = True
    farthest = np.zeros(DIRECTIONS)
    for i in range(points.shape[0]):
        if ground[i]:
            away = points[i, 0] ** 2 + points[i, 1] ** 2
            d = _direction(points[i, 0], points[i, 1])
            farthest[d] = max(farthest[d], away)
    out = np.empty((DIRECTIONS, 2))
    count = 0
    for d in range(DIRECTIONS):
        if farthest[d] > 0.0 and not stands[d]:
            angle = (d + 0.5) * 2.0 * math.pi / DIRECTIONS - math.pi
            away = math.sqrt(farthest[d])
            out[count, 0], out[count, 1] = away * math.cos(angle), away * math.sin(angle)
            count += 1
    return out[:count]


@njit(cache=True)
def _direction(x: float, y: float) -> int:
    return int((math.atan2(y, x) / (2.0 * math.pi) + 0.5) * DIRECTIONS) % DIRECTIONS
