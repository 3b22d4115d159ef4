"""String pulling: straighten a line that the footprint can follow, as far as it still can."""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.kernels import CACHED
from cohelm.planning.path_refinement.configuration_space import ConfigurationSpace, centre_is_free
from cohelm.planning.path_refinement.footprint import overlaps_along
from cohelm.planning.path_refinement.smoothing import curvature_of

_ITERATIONS = 15


@njit(**CACHED)
def pull_string(
    space: ConfigurationSpace,
    line: Floats,
    fixed: Booleans,
    pivot: Booleans,
    first: int,
    last: int,
) -> None:
    """Move points first … last in place to their neighbours' midpoint where the footprint fits.

    Args:
        space: the configuration space.
        line: (n, 2), changed in place, m.
        fixed: (n,), points that must not move.
        pivot: (n,), points where the robot turns on the spot.
        first, last: inner points.
    """
    limit = space.curvature
    for round_ in range(_ITERATIONS):
        moved = 0.0
        for k in range(first, last + 1):
            i = k if round_ % 2 == 0 else first + last - k
            if fixed[i]:
                continue
            ox, oy = line[i, 0], line[i, 1]
            x = 0.5 * (line[i - 1, 0] + line[i + 1, 0])
            y = 0.5 * (line[i - 1, 1] + line[i + 1, 1])
            step = math.hypot(x - ox, y - oy)
            if step < 1e-4 or not centre_is_free(space, x, y):
                continue
            # Keep the move only if curvature and footprint allow it nearby.
            line[i, 0], line[i, 1] = x, y
            low, high = max(i - 2, 0), min(i + 3, line.shape[0])
            bends = curvature_of(line[low:high])
            good = True
            for j in range(1, bends.shape[0] - 1):
                if bends[j] > limit and not pivot[low + j]:
                    good = False
            if good and not overlaps_along(space.footprint, line[low:high]).any():
                moved = max(moved, step)
            else:
                line[i, 0], line[i, 1] = ox, oy
        if moved < 1e-3:
            break
