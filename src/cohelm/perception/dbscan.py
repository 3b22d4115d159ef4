"""Density-based clustering (DBSCAN; Ester et al. 1996) of the points of a scan or a cloud.

scikit-learn's costs 1.2 ms for 360 points, almost all of it overhead; this one sorts the points
into cells as wide as the reach, compares those of neighbouring cells only, and lets the reach grow
with range as the beams' gaps do.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers

NOISE = -1
_MOST_CELLS = 1 << 20


@njit(cache=True)
def dbscan(points: Floats, reach: Floats, min_samples: int) -> Integers:
    """Cluster of each point, counted from 0, or −1 for noise.

    Args:
        points: (p, 2), m.
        reach: (p,) ε of each point, m; two points are neighbours within the larger of theirs.
        min_samples: neighbours, itself included, that make a core point.

    Returns:
        (p,), clusters numbered in the order of their first core point. A border point goes to the
        first cluster that reaches it.
    """
    n = points.shape[0]
    labels = np.full(n, NOISE, dtype=np.int64)
    if n == 0:
        return labels
    first, near = _neighbours(points, reach)
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
def _neighbours(points: Floats, reach: Floats) -> tuple[Integers, Integers]:
    """The neighbours of point i, itself included: ``near[first[i]:first[i + 1]]``."""
    n = points.shape[0]
    start, members, cell, cols = _cells(points, reach.max())
    first = np.zeros(n + 1, dtype=np.int64)
    near = np.empty(16 * n, dtype=np.int64)
    size = 0
    for i in range(n):
        x, y, eps = points[i, 0], points[i, 1], reach[i]
        for row in range(-1, 2):
            c = cell[i] + row * cols
            for k in range(start[c - 1], start[c + 2]):
                j = members[k]
                dx, dy, far = points[j, 0] - x, points[j, 1] - y, max(eps, reach[j])
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

    Cells are at least ``widest`` wide, so that neighbours lie in the 3 × 3 about a point's own;
    an empty border makes those exist.
    """
    n = points.shape[0]
    x0, y0 = points[:, 0].min(), points[:, 1].min()
    width, height = points[:, 0].max() - x0, points[:, 1].max() - y0
    side = max(widest * (1.0 + 1e-9), max(width, height) / math.sqrt(_MOST_CELLS), 1e-9)
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
