"""Nearest point of a path given as a polyline, for compiled code."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED

_ROUNDING = 1e-9
"""Upper bound of the rounding error of a square, as a share of it."""


class NearestPoint(NamedTuple):
    """Nearest point of a polyline."""

    distance: float
    """m."""
    remaining: float
    """Length of the polyline after the point, m."""
    x: float
    y: float


@njit(**CACHED)
def nearest_on_polyline(path: Floats, x: float, y: float) -> NearestPoint:
    """The point of a polyline (k, 2) nearest to (x, y)."""
    best, remaining, length_after, near_x, near_y = np.inf, 0.0, 0.0, path[0, 0], path[0, 1]
    worthwhile = np.inf
    for i in range(path.shape[0] - 2, -1, -1):
        dx, dy = path[i + 1, 0] - path[i, 0], path[i + 1, 1] - path[i, 1]
        px, py = x - path[i, 0], y - path[i, 1]
        length2 = dx * dx + dy * dy
        t = min(max((px * dx + py * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
        length = math.sqrt(length2)
        qx, qy = px - t * dx, py - t * dy
        if qx * qx + qy * qy <= worthwhile:  # the square first: roots are slow
            distance = math.hypot(qx, qy)
            if distance < best:
                best, remaining = distance, length_after + (1.0 - t) * length
                near_x, near_y = path[i, 0] + t * dx, path[i, 1] + t * dy
                worthwhile = best * best * (1.0 + _ROUNDING)
        length_after += length
    return NearestPoint(best, remaining, near_x, near_y)
