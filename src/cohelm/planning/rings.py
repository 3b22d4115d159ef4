"""Whether a line closes on itself: a ring, where a chair would go round to end up where it was."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.geometry import wrap_angle
from cohelm.planning.footprint import directions

_NEAR = 0.2  # m at which two points are at the same place
_BACK = math.radians(120.0)
_LEAST, _MOST = 0.8, 4.0  # m from one to the other along the line


@njit(cache=True)
def ring_in(points: Floats, pivots: Integers) -> tuple[int, int]:
    """The ends of the first stretch of a line (n, 2) that closes on itself; (−1, −1): none does.

    Its points lie within 0.2 m of each other and 0.8 to 4 m apart along the line, which nowhere
    between turns on the spot: out and back is no ring.

    Args:
        points: m.
        pivots: ascending indices (p,) of the points where the robot turns on the spot.
    """
    n = points.shape[0]
    along = np.zeros(n)
    for i in range(1, n):
        dx, dy = points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1]
        along[i] = along[i - 1] + math.hypot(dx, dy)
    first, pivot = 0, 0
    for i in range(n):
        while along[i] - along[first] > _MOST:
            first += 1
        while pivot < pivots.shape[0] and pivots[pivot] < i:
            first = max(first, pivots[pivot])
            pivot += 1
        for j in range(first, i):
            if along[i] - along[j] < _LEAST:
                break
            if math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]) < _NEAR:
                return j, i
    return -1, -1


def has_ring(points: Floats, pivots: Integers) -> bool:
    """Whether a line (n, 2) with turns on the spot (p,) closes on itself somewhere."""
    return ring_in(points, pivots)[0] >= 0


def turns_back(points: Floats) -> Integers:
    """Indices of the points of a line (n, 2) at which it turns by more than 120°."""
    turn = np.abs(wrap_angle(np.diff(directions(points))))
    return np.flatnonzero(turn > _BACK) + 1
