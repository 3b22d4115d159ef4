"""Which narrow passages a line comes through, however aslant.

A passage is where the line crosses between two places of walls that face each other: nothing stands
in the disc between them, so that they are the pinch itself and not two walls of one corner.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.maps.distance import sample

_SAME = 1.0  # m between the places of one passage at most


@njit(cache=True)
def narrow_passages(walls: Floats32, resolution: float, line: Floats, width: float) -> int:
    """How many passages narrower than ``width`` a line comes through.

    Args:
        walls: distance to what bodily stands there (rows, cols), m; negative inside.
        resolution: of the grid, m.
        line: (k, 2), grid's frame, points closer than a metre, m.
        width: between the surfaces on either side, m.
    """
    count, since = 0, np.inf
    for i in range(line.shape[0] - 1):
        step = line[i + 1] - line[i]
        length = math.hypot(step[0], step[1])
        if length == 0.0:
            continue
        if _between_walls(walls, resolution, line[i], step / length, length, width):
            count += since > _SAME
            since = 0.0
        else:
            since += length
    return count


@njit(cache=True)
def _between_walls(
    walls: Floats32, resolution: float, point: Floats, ahead: Floats, length: float, width: float
) -> bool:
    """Whether a straight step crosses a pinch narrower than ``width``."""
    room, _, _ = sample(walls, resolution, np.zeros(3), point[0], point[1])
    if room > 0.5 * width + length:
        return False
    left = _surface(walls, resolution, point, ahead, length + width, 1.0)
    if left.shape[0] == 0:
        return False
    right = _surface(walls, resolution, point, ahead, length + width, -1.0)
    for a in left:
        for b in right:
            dx = max(abs(a[2] - b[2]) - resolution, 0.0)
            dy = max(abs(a[3] - b[3]) - resolution, 0.0)
            apart = math.hypot(dx, dy)
            if apart >= width:
                continue
            crossed = (a[0] * b[1] + b[0] * a[1]) / (a[1] + b[1])
            if not 0.0 <= crossed < length:
                continue
            middle, _, _ = sample(
                walls, resolution, np.zeros(3), 0.5 * (a[2] + b[2]), 0.5 * (a[3] + b[3])
            )
            if middle >= 0.5 * apart - resolution:
                return True
    return False


@njit(cache=True)
def _surface(
    walls: Floats32, resolution: float, point: Floats, ahead: Floats, reach: float, side: float
) -> Floats:
    """(ahead, aside, x, y) of the cells at walls' surfaces on one side, centres, (n, 4), m."""
    rows, cols = walls.shape
    size = math.ceil(reach / resolution)
    row, col = math.floor(point[1] / resolution), math.floor(point[0] / resolution)
    out = np.empty((4 * size * size + 4 * size + 1, 4))
    count = 0
    for r in range(max(row - size, 0), min(row + size + 1, rows)):
        c = max(col - size, 0)
        while c < min(col + size + 1, cols):
            room = np.float64(walls[r, c])
            if -1.5 * resolution < room < 0.0:
                x, y = (c + 0.5) * resolution, (r + 0.5) * resolution
                dx, dy = x - point[0], y - point[1]
                aside = side * (ahead[0] * dy - ahead[1] * dx)
                if aside > 0.0:
                    out[count, 0], out[count, 1] = ahead[0] * dx + ahead[1] * dy, aside
                    out[count, 2], out[count, 3] = x, y
                    count += 1
            c += max(1, int(room / resolution))
    return out[:count]
