"""Pulling a line straight that the footprint can follow already, as far as it still can."""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.planning.footprint import met_along
from cohelm.planning.land import Land, centre_fits
from cohelm.planning.smoothing import curvature_of

_EASING = 15  # rounds


@njit(cache=True)
def ease(land: Land, line: Floats, fixed: Booleans, pivot: Booleans, first: int, last: int) -> None:
    """Move points first … last in place to their neighbours' middle where everything still fits.

    Args:
        land: where.
        line: (n, 2), changed in place, m.
        fixed: (n,), points that stay.
        pivot: (n,), points where the robot turns on the spot.
        first, last: inner points.
    """
    limit = land.curvature
    for round_ in range(_EASING):
        moved = 0.0
        for k in range(first, last + 1):
            i = k if round_ % 2 == 0 else first + last - k
            if fixed[i]:
                continue
            ox, oy = line[i, 0], line[i, 1]
            x = 0.5 * (line[i - 1, 0] + line[i + 1, 0])
            y = 0.5 * (line[i - 1, 1] + line[i + 1, 1])
            step = math.hypot(x - ox, y - oy)
            if step < 1e-4 or not centre_fits(land, x, y):
                continue
            line[i, 0], line[i, 1] = x, y
            low, high = max(i - 2, 0), min(i + 3, line.shape[0])
            bends = curvature_of(line[low:high])
            good = True
            for j in range(1, bends.shape[0] - 1):
                if bends[j] > limit and not pivot[low + j]:
                    good = False
            if good and not met_along(land.body, line[low:high]).any():
                moved = max(moved, step)
            else:
                line[i, 0], line[i, 1] = ox, oy
        if moved < 1e-3:
            break
