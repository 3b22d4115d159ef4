"""Density-based clustering (DBSCAN; Ester et al. 1996) of the few hundred points of a planar scan.

scikit-learn's costs 1.2 ms for 360 points, almost all of it overhead; this one compares every pair
in compiled code in a tenth of that, and lets the reach grow with range as the beams' gaps do.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers

NOISE = -1


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
    near = _neighbours(points, reach)
    core = np.empty(n, dtype=np.bool_)
    for i in range(n):
        core[i] = near[i].sum() >= min_samples
    labels = np.full(n, NOISE, dtype=np.int64)
    stack = np.empty(n, dtype=np.int64)
    cluster = 0
    for seed in range(n):
        if not core[seed] or labels[seed] != NOISE:
            continue
        labels[seed], stack[0], size = cluster, seed, 1
        while size > 0:
            size -= 1
            i = stack[size]
            for j in range(n):
                if near[i, j] and labels[j] == NOISE:
                    labels[j] = cluster
                    if core[j]:
                        stack[size] = j
                        size += 1
        cluster += 1
    return labels


@njit(cache=True)
def _neighbours(points: Floats, reach: Floats) -> Booleans:
    n = points.shape[0]
    near = np.zeros((n, n), dtype=np.bool_)
    for i in range(n):
        near[i, i] = True
        for j in range(i):
            dx, dy = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            eps = max(reach[i], reach[j])
            near[i, j] = near[j, i] = dx * dx + dy * dy <= eps * eps
    return near
