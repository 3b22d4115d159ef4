"""Costs of straight lines over weighted cells, and shortening of a path over cells by them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import ZERO
from cohelm.arrays import Floats, Floats32
from cohelm.kernels import CACHED, callee
from cohelm.maps.distance import sample
from cohelm.planning.grid_search.weights import Weights

_ORIGIN = np.zeros(3)


class LineGrid(NamedTuple):
    """Grids that a line is refined on, for kernels; points are in the grid's frame, m."""

    weights: Floats32
    """Packed weights of the search, (rows + 2, cols + 2)."""
    clearance: Floats32
    """Distance from cell centres to obstacles, (rows, cols), m."""
    resolution: float
    """Side of a cell, m."""
    needed: float
    """Clearance below which the line comes only where the path over cells did, m."""


def line_cost(points: Floats, weights: Weights, resolution: float) -> float:
    """Weighted length of a line (k, 2) in the grid's frame, m; ∞ if it crosses blocked cells.

    A point is blocked if all cells around it are; the first and the last point may be blocked.
    """
    return float(_line_cost(points, weights.packed, resolution))


@njit(**CACHED)
def _line_cost(points: Floats, weights: Floats32, resolution: float) -> float:
    total = 0.0
    for i in range(1, points.shape[0]):
        ax, ay = points[i - 1, 0], points[i - 1, 1]
        dx, dy = points[i, 0] - ax, points[i, 1] - ay
        length = math.hypot(dx, dy)
        count = max(math.ceil(4.0 * length / resolution), 1)
        # Trapezoidal rule over samples at most a quarter of a cell apart.
        inner, ends = 0.0, 0.0
        for k in range(count + 1):
            x, y = ax + dx * k / count, ay + dy * k / count
            w = _weight(weights, resolution, x, y)
            if w == np.inf:
                if not ((i == 1 and k == 0) or (i == points.shape[0] - 1 and k == count)):
                    return np.inf
                w = 0.0
            if k in (0, count):
                ends += 0.5 * w
            else:
                inner += w
        total += (inner + ends) * length / count if length > 0.0 else 0.0
    return total


@njit(**CACHED)
def shorten(points: Floats, grid: LineGrid, wanted: float) -> Floats:
    """Replace stretches of a path by straight segments; returns the remaining corners (m, 2).

    A segment costs no more than the stretch and keeps the clearance of the stretch, or ``wanted``
    where that is less, m.
    """
    n = points.shape[0]
    along = np.zeros(n)  # cost of the path up to each point
    near = np.empty(n)
    for i in range(n):
        near[i] = clearance_at(grid.clearance, grid.resolution, points[i, 0], points[i, 1])
        if i > 0:
            cost, _ = _segment(points[i - 1], points[i], grid)
            along[i] = along[i - 1] + cost
    i = ZERO
    kept = [i]
    while i < n - 1:
        good, step = i + 1, 2
        bad = n
        while good < n - 1:
            # Double the stride while it works, then halve toward the first that does not.
            j = min(good + step, n - 1) if bad == n else (good + bad) // 2
            if j == good:
                break
            if _may_replace(i, j, points, along, near, grid, wanted):
                good = j
                step *= 2
            else:
                bad = j
        i = max(good, i + 1)
        kept.append(i)
    out = np.empty((len(kept), 2))
    for k in range(len(kept)):
        out[k, 0], out[k, 1] = points[kept[k], 0], points[kept[k], 1]
    return out


@callee()
def _may_replace(
    i: int, j: int, points: Floats, along: Floats, near: Floats, grid: LineGrid, wanted: float
) -> bool:
    """Check that the segment i–j costs no more than the path and keeps enough clearance."""
    cost, clear = _segment(points[i], points[j], grid)
    if cost > (along[j] - along[i]) * (1.0 + 1e-9) + 1e-12:
        return False
    floor = wanted
    for k in range(i, j + 1):
        floor = min(floor, near[k])
    return clear >= floor - 1e-9


@callee()
def _segment(a: Floats, b: Floats, grid: LineGrid) -> tuple[float, float]:
    """(cost of a straight segment, m; its minimum clearance, m), sampled every quarter cell."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = math.hypot(dx, dy)
    count = max(math.ceil(4.0 * length / grid.resolution), 1)
    total, near = 0.0, np.inf
    for k in range(count + 1):
        x, y = a[0] + dx * k / count, a[1] + dy * k / count
        near = min(near, clearance_at(grid.clearance, grid.resolution, x, y))
        if closed_by_rule(grid, x, y):
            return np.inf, near
        share = 0.5 if k in (0, count) else 1.0
        total += share * _weight(grid.weights, grid.resolution, x, y)
    return total * length / count, near


@callee()
def _weight(weights: Floats32, resolution: float, x: float, y: float) -> float:
    """Weight at a point, bilinear between the cell centres that are not blocked."""
    c, r = x / resolution + 0.5, y / resolution + 0.5  # the packed grid starts one cell earlier
    c0, r0 = math.floor(c), math.floor(r)
    c0 = min(max(c0, 0), weights.shape[1] - 2)
    r0 = min(max(r0, 0), weights.shape[0] - 2)
    u, v = min(max(c - c0, 0.0), 1.0), min(max(r - r0, 0.0), 1.0)
    total, share = 0.0, 0.0
    for i in range(2):
        for j in range(2):
            w = np.float64(weights[r0 + i, c0 + j])
            part = (v if i else 1.0 - v) * (u if j else 1.0 - u)
            if w < np.inf:
                total += part * w
                share += part
    return total / share if share > 1e-9 else np.inf


@callee()
def clearance_at(clearance: Floats32, resolution: float, x: float, y: float) -> float:
    """Clearance at a point, bilinear between the cell centres, m."""
    distance, _, _ = sample(clearance, resolution, _ORIGIN, x, y)
    return distance


@callee()
def closed_by_rule(grid: LineGrid, x: float, y: float) -> bool:
    """Check that a point's cell is blocked by a zone, not by an obstacle near it."""
    clearance = grid.clearance
    r = min(max(math.floor(y / grid.resolution), 0), clearance.shape[0] - 1)
    c = min(max(math.floor(x / grid.resolution), 0), clearance.shape[1] - 1)
    return bool(grid.weights[r + 1, c + 1] == np.inf and clearance[r, c] > grid.needed)
