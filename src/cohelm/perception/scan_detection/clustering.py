"""Density-based clustering of points, and the smallest ellipse about each cluster.

DBSCAN (Ester et al. 1996) is implemented here because scikit-learn takes 1.2 ms for 360 points,
almost all of it overhead, and has one ε for all points; this one lets ε grow with range as the gaps
between beams do. The ellipses are the obstacles of MPC-DCBF (Jian et al. 2022).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers

NOISE = -1
_MAX_CELLS = 1 << 20
_TOLERANCE = 1e-3
"""Relative excess of an ellipse's area over the smallest one at which the iteration ends."""
_ITERATIONS = 200
_NO_HULL = 6
"""Number of points up to which no hull is computed."""


@njit(cache=True)
def dbscan(points: Floats, epsilon: Floats, min_samples: int) -> Integers:
    """Cluster points; return the cluster of each, counted from 0, or −1 for noise.

    Args:
        points: (p, 2), m.
        epsilon: (p,) ε of each point, m; two points are neighbours within the larger of theirs.
        min_samples: neighbours, itself included, that make a core point.

    Returns:
        (p,), clusters in the order of their first core point. A border point belongs to the first
        cluster that reaches it.
    """
    n = points.shape[0]
    labels = np.full(n, NOISE, dtype=np.int64)
    if n == 0:
        return labels
    first, near = _neighbours(points, epsilon)
    stack = np.empty(n, dtype=np.int64)
    cluster = 0
    for seed in range(n):
        if first[seed + 1] - first[seed] < min_samples or labels[seed] != NOISE:
            continue
        labels[seed], stack[0], size = cluster, seed, 1
        while size > 0:
            size -= 1
            i = stack[size]
            for j in near[first[i] : first[i + 1]]:
                if labels[j] == NOISE:
                    labels[j] = cluster
                    if first[j + 1] - first[j] >= min_samples:
                        stack[size] = j
                        size += 1
        cluster += 1
    return labels


@njit(cache=True)
def _neighbours(points: Floats, epsilon: Floats) -> tuple[Integers, Integers]:
    """Neighbours of point i, itself included: ``near[first[i]:first[i + 1]]``."""
    n = points.shape[0]
    start, members, cell, cols = _cells(points, epsilon.max())
    first = np.zeros(n + 1, dtype=np.int64)
    near = np.empty(16 * n, dtype=np.int64)
    size = 0
    for i in range(n):
        x, y, eps = points[i, 0], points[i, 1], epsilon[i]
        for row in range(-1, 2):
            c = cell[i] + row * cols
            for k in range(start[c - 1], start[c + 2]):
                j = members[k]
                dx, dy, far = points[j, 0] - x, points[j, 1] - y, max(eps, epsilon[j])
                if dx * dx + dy * dy <= far * far:
                    if size == near.size:
                        near = np.concatenate((near, np.empty_like(near)))
                    near[size] = j
                    size += 1
        first[i + 1] = size
    return first, near[:size]


@njit(cache=True)
def _cells(points: Floats, widest: float) -> tuple[Integers, Integers, Integers, int]:
    """(first member of each cell, members by cell, cell of each point, cells in a row).

    Cells are at least ``widest`` wide, so that all neighbours lie in the 3 × 3 cells about a point;
    an empty border makes these exist.
    """
    n = points.shape[0]
    x0, y0 = points[:, 0].min(), points[:, 1].min()
    width, height = points[:, 0].max() - x0, points[:, 1].max() - y0
    side = max(widest * (1.0 + 1e-9), max(width, height) / math.sqrt(_MAX_CELLS), 1e-9)
    cols, rows = int(width / side) + 3, int(height / side) + 3
    cell = np.empty(n, dtype=np.int64)
    start = np.zeros(rows * cols + 2, dtype=np.int64)
    for i in range(n):
        row = int((points[i, 1] - y0) / side) + 1
        cell[i] = row * cols + int((points[i, 0] - x0) / side) + 1
        start[cell[i] + 1] += 1
    for c in range(rows * cols + 1):
        start[c + 1] += start[c]
    at = start.copy()
    members = np.empty(n, dtype=np.int64)
    for i in range(n):
        members[at[cell[i]]] = i
        at[cell[i]] += 1
    return start, members, cell, cols


@njit(cache=True)
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
    order = np.argsort(labels, kind="mergesort")
    first = np.searchsorted(labels[order], np.arange(count + 1))
    for k in range(count):
        members = points[order[first[k] : first[k + 1]]]
        if members.shape[0]:
            out[k] = _about(_hull(members), thinnest)
    return out


@njit(cache=True)
def _hull(points: Floats) -> Floats:
    """Corners of the convex hull (Andrew 1979): the ellipse depends on no other point."""
    m = points.shape[0]
    if m <= _NO_HULL:
        return points
    order = np.argsort(points[:, 1], kind="mergesort")
    order = order[np.argsort(points[order, 0], kind="mergesort")]
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


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
def _farthest(dx: Floats, dy: Floats, sxx: float, sxy: float, syy: float) -> tuple[int, float]:
    """Index of the farthest point in units of the moments, and its squared distance."""
    det = sxx * syy - sxy * sxy
    far, most = 0, -np.inf
    for i in range(dx.size):
        squared = (syy * dx[i] * dx[i] - 2.0 * sxy * dx[i] * dy[i] + sxx * dy[i] * dy[i]) / det
        if squared > most:
            far, most = i, squared
    return far, most
