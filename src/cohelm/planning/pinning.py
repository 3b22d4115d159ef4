"""How a line turns at a place that it must pass: about a disc, not about a point.

Held at a point only, a taut line has a corner there, which the robot cannot drive. So where a line
turns at a pin by more than the robot can, a disc of the least radius that it can drive is put
inside the corner, touching the pin: pulled taut about that, the line passes the pin on an arc.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats

_SHARPEST = math.radians(120.0)  # beyond it the robot turns on the spot and goes back


@njit(cache=True)
def discs_at(line: Floats, pinned: Booleans, curvature: float) -> Floats:
    """The disc (x, y, radius) that each point of a line must stay out of, (n, 3); radius 0: none.

    Args:
        line: (n, 2), m; its points do not repeat.
        pinned: which of them it must pass.
        curvature: of the discs, 1/m.
    """
    n = line.shape[0]
    out = np.zeros((n, 3))
    stops = np.flatnonzero(pinned)
    radius = 1.0 / curvature
    for k in range(1, stops.shape[0] - 1):
        i = stops[k]
        ax, ay = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
        bx, by = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
        before, after = math.hypot(ax, ay), math.hypot(bx, by)
        turn = abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
        if turn <= curvature * 0.5 * (before + after) or turn > _SHARPEST:
            continue
        nx, ny = bx / after - ax / before, by / after - ay / before
        inward = radius / math.hypot(nx, ny)
        for step in (-1, 1):
            j, far = i, 0.0
            while far <= 2.0 * radius and (j == i or not pinned[j]):
                out[j, 0], out[j, 1] = line[i, 0] + inward * nx, line[i, 1] + inward * ny
                out[j, 2] = radius
                j += step
                far += before if step < 0 else after
    return out


@njit(cache=True)
def pushed_out(disc: Floats, x: float, y: float) -> tuple[float, float]:
    """The nearest place outside a disc (x, y, radius)."""
    dx, dy = x - disc[0], y - disc[1]
    far = math.hypot(dx, dy)
    if far >= disc[2] or far == 0.0:
        return x, y
    return disc[0] + dx * disc[2] / far, disc[1] + dy * disc[2] / far
