"""Smallest ellipse about each cluster, the obstacle of MPC-DCBF (Jian et al. 2022)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.array_kernels import copy_row, members_by_label, stable_order
from cohelm.arrays import Floats, Integers
from cohelm.kernels import CACHED, callee

_TOLERANCE = 1e-3
"""Relative excess of an ellipse's area over the smallest one at which the iteration ends."""
_ITERATIONS = 200
_NO_HULL = 6
"""Number of points up to which no hull is computed."""


@njit(**CACHED)
def bounding_ellipses(points: Floats, labels: Integers, count: int, thinnest: float) -> Floats:
    """Compute the smallest ellipse about each cluster; (count, 5) of (x, y, a, b, direction of a).

    Khachiyan's algorithm with the step of Todd and Yıldırım (2007), on points relative to their
    mean. Semi-axes are at least ``thinnest``, so that single and collinear points have one, too.

    Args:
        points: (p, 2) m.
        labels: (p,) cluster of each point, −1: none.
        count: number of clusters.
        thinnest: smallest semi-axis, m, > 0.
    """
    out = np.zeros((count, 5))
    order, first = members_by_label(labels, count)
    for k in range(count):
        members = points[order[first[k] : first[k + 1]]]
        if members.shape[0]:
            copy_row(out[k], _about(_hull(members), thinnest))
    return out


@callee()
def _hull(points: Floats) -> Floats:
    """Corners of the convex hull (Andrew 1979): the ellipse depends on no other point."""
    m = points.shape[0]
    if m <= _NO_HULL:
        return points
    order = stable_order(points[:, 1].copy())
    order = order[stable_order(points[order, 0])]
    corners = np.empty(2 * m, dtype=np.int64)
    size = 0
    for side in range(2):
        start = size
        for step in range(m):
            i = order[step if side == 0 else m - 1 - step]
            while size >= start + 2:
                a, b, p = points[corners[size - 2]], points[corners[size - 1]], points[i]
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0:
                    break
                size -= 1
            corners[size] = i
            size += 1
        size -= 1  # the last corner of one side is the first of the next
    return points[corners[: max(size, 1)]]


@callee()
def _about(points: Floats, thinnest: float) -> Floats:
    """Smallest ellipse (5,) about the points (m, 2) of one cluster."""
    m = points.shape[0]
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    x, y = points[:, 0] - mx, points[:, 1] - my
    u = np.full(m, 1.0 / m)
    # Each point counts as a small disc: keeps the moments of collinear points regular.
    floor = (0.1 * thinnest) ** 2
    cx = cy = 0.0
    sxx = sxy = syy = 1.0
    for _ in range(_ITERATIONS):
        cx, cy, sxx, sxy, syy = _moments(x, y, u, floor)
        far, most = _farthest(x - cx, y - cy, sxx, sxy, syy)
        excess = most + 1.0
        if excess <= 3.0 * (1.0 + _TOLERANCE):
            break
        step = (excess - 3.0) / (3.0 * (excess - 1.0))
        u *= 1.0 - step
        u[far] += step
    _, scale = _farthest(x - cx, y - cy, sxx, sxy, syy)
    half, spread = 0.5 * (sxx + syy), math.hypot(0.5 * (sxx - syy), sxy)
    a = max(math.sqrt(max((half + spread) * scale, 0.0)), thinnest)
    b = max(math.sqrt(max((half - spread) * scale, 0.0)), thinnest)
    return np.array([cx + mx, cy + my, a, b, 0.5 * math.atan2(2.0 * sxy, sxx - syy)])


@callee()
def _moments(
    x: Floats, y: Floats, u: Floats, floor: float
) -> tuple[float, float, float, float, float]:
    """Mean (x, y) and second moments (xx, xy, yy) of points with weights (m,) of sum 1."""
    cx = cy = 0.0
    for i in range(u.size):
        cx += u[i] * x[i]
        cy += u[i] * y[i]
    sxx = sxy = syy = 0.0
    for i in range(u.size):
        dx, dy = x[i] - cx, y[i] - cy
        sxx += u[i] * dx * dx
        sxy += u[i] * dx * dy
        syy += u[i] * dy * dy
    return cx, cy, sxx + floor, sxy, syy + floor


@callee()
def _farthest(dx: Floats, dy: Floats, sxx: float, sxy: float, syy: float) -> tuple[int, float]:
    """Index of the farthest point in units of the moments, and its squared distance."""
    det = sxx * syy - sxy * sxy
    far, most = 0, -np.inf
    for i in range(dx.size):
        squared = (syy * dx[i] * dx[i] - 2.0 * sxy * dx[i] * dy[i] + sxx * dy[i] * dy[i]) / det
        if squared > most:
            far, most = i, squared
    return far, most
