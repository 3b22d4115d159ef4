"""How near the footprint comes to what stands there: exactly, from outline to cells' squares.

Discs that cover the footprint tell at once where it is far from everything; the poses are looked
at in the order of what these say, so that few are left for which outline and squares are compared.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.planning.footprint import Body, directions, overlaps, spare, turn_between

_SPACING = 0.025  # m between poses, and between those of the farthest corner in a turn


@njit(cache=True)
def poses_driven(points: Floats, reach: float) -> Floats:
    """Poses (m, 3) on a polyline (n, 2): with each segment's heading, and turning at its points.

    Args:
        points: m; they do not repeat.
        reach: to the farthest corner, m.
    """
    heading = directions(points)
    poses = [np.array([points[0, 0], points[0, 1], heading[0] if len(heading) else 0.0])]
    for i in range(heading.shape[0]):
        if i > 0:
            turn = turn_between(heading[i - 1], heading[i])
            count = math.ceil(abs(turn) * reach / _SPACING)
            for k in range(1, count):
                angle = heading[i - 1] + turn * k / count
                poses.append(np.array([points[i, 0], points[i, 1], angle]))
        step = points[i + 1] - points[i]
        count = max(math.ceil(math.hypot(step[0], step[1]) / _SPACING), 1)
        for k in range(0 if i > 0 else 1, count + 1):
            at = points[i] + step * (k / count)
            poses.append(np.array([at[0], at[1], heading[i]]))
    out = np.empty((len(poses), 3))
    for i in range(len(poses)):
        out[i] = poses[i]
    return out


@njit(cache=True)
def least_gap_of(body: Body, outline: Floats, poses: Floats) -> float:
    """Least distance from the outline (k, 2) at any of the poses (n, 3) to what blocks, m.

    0 where it overlaps; ∞ where nothing blocks anywhere near.
    """
    bounds = np.empty(poses.shape[0])
    for i in range(poses.shape[0]):
        bounds[i] = spare(body, poses[i, 0], poses[i, 1], poses[i, 2])
    best = np.inf
    for i in np.argsort(bounds):
        if bounds[i] >= best or best == 0.0:
            break
        # Nothing is looked for beyond what is the least so far, nor much beyond the bound.
        reach = bounds[i] + body.bound[2] + 2.0 * body.resolution
        best = min(best, _gap(body, outline, poses[i], min(best, max(reach, 0.0))))
        if best == np.inf:
            best = _gap(body, outline, poses[i], np.inf)
    return best


@njit(cache=True)
def _gap(body: Body, outline: Floats, pose: Floats, most: float) -> float:
    """The distance from the outline at a pose to what blocks; ∞ where it is ``most`` or more."""
    x, y, heading = pose
    if overlaps(body, x, y, heading):
        return 0.0
    cos, sin = math.cos(heading), math.sin(heading)
    corners = np.empty_like(outline)
    for k in range(outline.shape[0]):
        corners[k, 0] = x + cos * outline[k, 0] - sin * outline[k, 1]
        corners[k, 1] = y + sin * outline[k, 0] + cos * outline[k, 1]
    rows, cols = body.clearance.shape
    res = body.resolution
    best = most
    r = _cell(corners[:, 1].min() - best, res, rows)
    while r < rows and r * res <= corners[:, 1].max() + best:
        c = _cell(corners[:, 0].min() - best, res, cols)
        while c < cols and c * res <= corners[:, 0].max() + best:
            room = min(np.float64(body.clearance[r, c]), body.trust)
            if room < 0.0:
                best = min(best, _to_square(corners, c * res, r * res, res))
            c += max(1, int(room / res))
        r += 1
    return best if best < most else np.inf


@njit(cache=True)
def _cell(x: float, resolution: float, count: int) -> int:
    """The cell of a coordinate, the nearest there is."""
    return int(min(max(x / resolution, 0.0), float(count - 1)))


@njit(cache=True)
def _to_square(corners: Floats, left: float, low: float, side: float) -> float:
    """Distance between a polygon (k, 2) and a square that it does not overlap."""
    best = np.inf
    n = corners.shape[0]
    for k in range(n):
        ax, ay = corners[k, 0], corners[k, 1]
        dx = max(left - ax, 0.0, ax - left - side)
        dy = max(low - ay, 0.0, ay - low - side)
        best = min(best, dx * dx + dy * dy)
        bx, by = corners[(k + 1) % n, 0] - ax, corners[(k + 1) % n, 1] - ay
        square = bx * bx + by * by
        for corner in range(4):
            px = left + side * (corner % 2) - ax
            py = low + side * (corner // 2) - ay
            t = min(max((px * bx + py * by) / square, 0.0), 1.0)
            best = min(best, (px - t * bx) ** 2 + (py - t * by) ** 2)
    return math.sqrt(best)
