"""Distance between a robot's capsule and a point.

``Robot.capsule`` is (x_a, y_a, x_b, y_b, radius): all points within a radius of the spine, which is
the segment from a to b in the robot frame.
"""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED

_SMOOTH = 1e-6
"""Added to squared distances, m²: it bounds the gradient of the distance at the spine."""


@njit(**CACHED, inline="always")
def nearest_on_spine(
    capsule: Floats, cos: float, sin: float, dx: float, dy: float
) -> tuple[float, float, float, float, float, bool]:
    """(distance, unit vector from the spine to the point, nearest point, inside the spine).

    All in the robot frame. The last value is True where the nearest point is not an end.

    Args:
        capsule: as ``Robot.capsule``.
        cos, sin: of the robot's heading.
        dx, dy: from the robot to the point, in the map frame, m.
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


@njit(**CACHED, inline="always")
def nearest_on_spine_in_map(
    capsule: Floats, pose: Floats, x: float, y: float
) -> tuple[float, float, float, float, float, bool]:
    """(distance, unit vector to the point (x, y), arm rotated by 90°, inside the spine).

    All in the map frame. The arm leads from ``pose`` (3,) to the nearest point of the spine.
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    distance, ex, ey, sx, sy, inside = nearest_on_spine(capsule, cos, sin, x - pose[0], y - pose[1])
    nx, ny = cos * ex - sin * ey, sin * ex + cos * ey
    arm_x, arm_y = -(sin * sx + cos * sy), cos * sx - sin * sy
    return distance, nx, ny, arm_x, arm_y, inside


@njit(**CACHED, inline="always")
def gap_to_disc(capsule: Floats, pose: Floats, x: float, y: float, radius: float) -> float:
    """Gap between the capsule at ``pose`` (3,) and a disc at (x, y), m; negative if they overlap.

    This is the only distance between footprint and body in planners and safety gate.
    """
    gap: float = nearest_on_spine_in_map(capsule, pose, x, y)[0] - capsule[4] - radius
    return gap
