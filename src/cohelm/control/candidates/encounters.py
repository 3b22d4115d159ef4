"""What an arc meets: kernels for walls, bodies, personal spaces and the hulls of groups."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.candidates.hulls import Hulls
from cohelm.control.candidates.scene import Crowd, Walls
from cohelm.maps.distance import sample

_ROUNDING = 1e-9
"""m."""


@njit(cache=True, error_model="numpy")
def wall_price(  # noqa: PLR0917  # a kernel takes plain values
    walls: Walls,
    discs: Floats,
    around: float,
    x: float,
    y: float,
    angle: float,
    clearance: float,
) -> tuple[float, bool, float]:
    """(how far one may go before looking again, whether a wall is touched, (missing share)²)."""
    room = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0] - around - clearance
    if room > 0.0:
        return room, False, 0.0
    nearest = np.inf
    cos, sin = math.cos(angle), math.sin(angle)
    for j in range(discs.shape[0]):
        u = x + cos * discs[j, 0] - sin * discs[j, 1]
        v = y + sin * discs[j, 0] + cos * discs[j, 1]
        gap = sample(walls.distance, walls.resolution, walls.X_MG, u, v)[0] - discs[j, 2]
        if gap < walls.margin[j]:
            return 0.0, True, 0.0
        nearest = min(nearest, gap)
    close = max(clearance - nearest, 0.0) / max(clearance, 1e-6)
    return 0.0, False, close * close


@njit(cache=True, error_model="numpy")
def body_gap(capsule: Floats, angle: float, dx: float, dy: float) -> tuple[float, float, float]:
    """(gap between the capsule and a point at (dx, dy) from the pose, unit vector to it)."""
    cos, sin = math.cos(angle), math.sin(angle)
    qx, qy = cos * dx + sin * dy - capsule[0], cos * dy - sin * dx - capsule[1]
    bx, by = capsule[2] - capsule[0], capsule[3] - capsule[1]
    square = bx * bx + by * by
    t = min(max((qx * bx + qy * by) / square, 0.0), 1.0) if square > 0.0 else 0.0
    ex, ey = qx - t * bx, qy - t * by
    d = math.sqrt(ex * ex + ey * ey + 1e-12)
    ex, ey = ex / d, ey / d
    return d - capsule[4], cos * ex - sin * ey, sin * ex + cos * ey


@njit(cache=True, error_model="numpy")
def space_entered(crowd: Crowd, state: Floats, gap: float, nx: float, ny: float) -> float:
    """The squared share of a personal space that is entered; (nx, ny) points to the person."""
    ahead = -(nx * state[2] + ny * state[3])
    square = ahead * ahead
    q = (state[4] if ahead > 0.0 else state[5]) * square + state[6] * (1.0 - square)
    reach = max(crowd.scale / q if crowd.printed else math.sqrt(crowd.scale / q), crowd.floor)
    share = max(reach - gap, 0.0) / reach if reach > 0.0 else 0.0
    return share * share


@njit(cache=True, error_model="numpy")
def depth_in_hulls(
    hulls: Hulls, capsule: Floats, x: float, y: float, angle: float, k: int
) -> float:
    """Sum of squared depths of the robot's middle, grown by its half width, in hulls; m²."""
    mx, my = 0.5 * (capsule[0] + capsule[2]), 0.5 * (capsule[1] + capsule[3])
    near, off = False, math.sqrt(mx * mx + my * my) + capsule[4] + _ROUNDING
    for g in range(hulls.support.shape[0]):
        dx, dy = x - hulls.disc[g, k, 0], y - hulls.disc[g, k, 1]
        reach = hulls.disc[g, k, 2] + off
        near |= dx * dx + dy * dy < reach * reach
    if not near:
        return 0.0
    cos, sin = math.cos(angle), math.sin(angle)
    x, y = x + cos * mx - sin * my, y + sin * mx + cos * my
    total = 0.0
    for g in range(hulls.support.shape[0]):
        dx, dy = x - hulls.disc[g, k, 0], y - hulls.disc[g, k, 1]
        reach = hulls.disc[g, k, 2] + capsule[4]
        if dx * dx + dy * dy >= reach * reach:
            continue
        depth = np.inf
        for j in range(hulls.normal.shape[0]):
            inner = hulls.support[g, k, j] - x * hulls.normal[j, 0] - y * hulls.normal[j, 1]
            depth = min(depth, inner + capsule[4])
            if depth <= 0.0:
                break
        if depth > 0.0:
            total += depth * depth
    return total
