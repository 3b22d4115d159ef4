"""What a straight line costs over weighted cells, and where it may take the place of cells."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.maps.distance import sample
from cohelm.planning.search import Weights

_ORIGIN = np.zeros(3)


def line_cost(points: Floats, weights: Weights, resolution: float) -> float:
    """Weighted length of a line (k, 2) in the grid's frame, m; ∞ where it crosses what is blocked.

    Blocked is a point between blocked cells on all sides; the first and the last are forgiven.
    """
    return float(_line_cost(points, weights.packed, resolution))


@njit(cache=True)
def _line_cost(points: Floats, weights: Floats32, resolution: float) -> float:
    total = 0.0
    for i in range(1, points.shape[0]):
        ax, ay = points[i - 1, 0], points[i - 1, 1]
        dx, dy = points[i, 0] - ax, points[i, 1] - ay
        length = math.hypot(dx, dy)
        count = max(math.ceil(4.0 * length / resolution), 1)
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


@njit(cache=True)
def shorten(
    points: Floats,
    weights: Floats32,
    clearance: Floats32,
    resolution: float,
    needed: float,
    wanted: float,
) -> Floats:
    """The corners (m, 2) that are left when straight segments replace what they can.

    They come no nearer to obstacles than the way did, or than what is wanted.
    """
    n = points.shape[0]
    along = np.zeros(n)  # what the way costs up to each point
    least = np.empty(n)
    for i in range(n):
        least[i] = clearance_at(clearance, resolution, points[i, 0], points[i, 1])
        if i > 0:
            cost, _ = _segment(points[i - 1], points[i], weights, clearance, resolution, needed)
            along[i] = along[i - 1] + cost
    kept = [0]
    i = 0
    while i < n - 1:
        good, step = i + 1, 2
        bad = n
        while good < n - 1:
            # Double the stride while it works, then halve toward the first that does not.
            j = min(good + step, n - 1) if bad == n else (good + bad) // 2
            if j == good:
                break
            if _may_replace(
                i, j, points, along, least, weights, clearance, resolution, needed, wanted
            ):
                good = j
                step *= 2
            else:
                bad = j
        i = max(good, i + 1)
        kept.append(i)
    out = np.empty((len(kept), 2))
    for k in range(len(kept)):
        out[k] = points[kept[k]]
    return out


@njit(cache=True)
def _may_replace(  # noqa: PLR0913, PLR0917  # a kernel takes plain arguments
    i: int,
    j: int,
    points: Floats,
    along: Floats,
    least: Floats,
    weights: Floats32,
    clearance: Floats32,
    resolution: float,
    needed: float,
    wanted: float,
) -> bool:
    """Whether the segment i–j costs no more than the way and stays as clear as it must."""
    cost, near = _segment(points[i], points[j], weights, clearance, resolution, needed)
    if cost > (along[j] - along[i]) * (1.0 + 1e-9) + 1e-12:
        return False
    floor = wanted
    for k in range(i, j + 1):
        floor = min(floor, least[k])
    return near >= floor - 1e-9


@njit(cache=True)
def _segment(
    a: Floats, b: Floats, weights: Floats32, clearance: Floats32, resolution: float, needed: float
) -> tuple[float, float]:
    """(cost of a straight segment, m; least clearance on it, m), sampled every quarter cell."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = math.hypot(dx, dy)
    count = max(math.ceil(4.0 * length / resolution), 1)
    total, near = 0.0, np.inf
    for k in range(count + 1):
        x, y = a[0] + dx * k / count, a[1] + dy * k / count
        near = min(near, clearance_at(clearance, resolution, x, y))
        if barred(weights, clearance, resolution, needed, x, y):
            return np.inf, near
        share = 0.5 if k in (0, count) else 1.0
        total += share * _weight(weights, resolution, x, y)
    return total * length / count, near


@njit(cache=True)
def _weight(weights: Floats32, resolution: float, x: float, y: float) -> float:
    """The weight at a point, bilinear between the cell centres that are not blocked."""
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


@njit(cache=True)
def clearance_at(clearance: Floats32, resolution: float, x: float, y: float) -> float:
    """The clearance at a point, bilinear between the cell centres, m."""
    distance, _, _ = sample(clearance, resolution, _ORIGIN, x, y)
    return distance


@njit(cache=True)
def barred(
    weights: Floats32, clearance: Floats32, resolution: float, needed: float, x: float, y: float
) -> bool:
    """Whether a point's cell is blocked though it is clear of obstacles: by a zone."""
    r = min(max(math.floor(y / resolution), 0), clearance.shape[0] - 1)
    c = min(max(math.floor(x / resolution), 0), clearance.shape[1] - 1)
    return bool(weights[r + 1, c + 1] == np.inf and clearance[r, c] > needed)
