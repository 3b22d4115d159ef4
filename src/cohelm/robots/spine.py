"""The nearest point of a robot's spine, the segment that its capsule is the neighbourhood of."""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Floats

_SMOOTH = 1e-6
"""Added to squared distances, m²: their gradient is bounded at the spine, too."""


@njit(cache=True, inline="always")
def foot_on_spine(
    capsule: Floats, cos: float, sin: float, dx: float, dy: float
) -> tuple[float, float, float, float, float, bool]:
    """(distance, unit vector from the spine to a point, the spine's point, whether inside it).

    All in the robot frame.

    Args:
        capsule: as ``Robot.capsule``.
        cos, sin: of the robot's heading.
        dx, dy: from the robot to the point, in the map frame.
    """
    qx, qy = cos * dx + sin * dy, -sin * dx + cos * dy
    ax, ay = capsule[0], capsule[1]
    bx, by = capsule[2] - ax, capsule[3] - ay
    length2 = bx * bx + by * by
    t = ((qx - ax) * bx + (qy - ay) * by) / length2 if length2 > 0.0 else 0.0
    inside = 0.0 < t < 1.0
    t = min(max(t, 0.0), 1.0)
    sx, sy = ax + t * bx, ay + t * by
    ex, ey = qx - sx, qy - sy
    distance = math.sqrt(ex * ex + ey * ey + _SMOOTH)
    return distance, ex / distance, ey / distance, sx, sy, inside
