"""Loops in a line: stretches where a chair would drive around to return to the same place."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.geometry import wrap_angle
from cohelm.kernels import CACHED
from cohelm.planning.path_refinement.footprint import directions

_NEAR = 0.2  # m between two points at the same place
_REVERSAL = math.radians(120.0)
_SHORTEST, _LONGEST = 0.8, 4.0  # m from one to the other along the line


@njit(**CACHED)
def find_loop(points: Floats, pivots: Integers) -> tuple[int, int]:
    """Ends of the first loop in a line (n, 2); (−1, −1) if there is none.

    The ends of a loop lie within 0.2 m of each other and 0.8 to 4 m apart along the line, and the
    robot does not turn on the spot between them: out and back is not a loop.

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
        # Candidates are the points since the last pivot, not too far back along the line.
        while along[i] - along[first] > _LONGEST:
            first += 1
        while pivot < pivots.shape[0] and pivots[pivot] < i:
            first = max(first, pivots[pivot])
            pivot += 1
        for j in range(first, i):
            if along[i] - along[j] < _SHORTEST:
                break
            if math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]) < _NEAR:
                return j, i
    return -1, -1


def has_loop(points: Floats, pivots: Integers) -> bool:
    """Check that a line (n, 2) with turns on the spot (p,) contains a loop."""
    return find_loop(points, pivots)[0] >= 0


def reversal_points(points: Floats) -> Integers:
    """Indices of the points of a line (n, 2) at which it turns by more than 120°."""
    turn = np.abs(wrap_angle(np.diff(directions(points))))
    return np.flatnonzero(turn > _REVERSAL) + 1
