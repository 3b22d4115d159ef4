"""Split of clusters of columns in which several people or objects touch."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import members_by_label, stable_order
from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED, callee

_DIRECTIONS = 720
"""Directions of a full turn for occlusion (0.5° each)."""
_OCCLUSION_STEP = 0.25
"""An object nearer by this in the same direction occludes another one, m."""
_HEAD_SHARES, _HEAD_WIDTH = (0.86, 0.89, 0.92, 0.95), 0.3
"""A head reaches above one of these shares of the top (shoulders are at 0.82 of a body's height,
Drillis and Contini 1966); the outer sides of two heads are at least so far apart, m."""
_MIN_HEIGHT = 1.1
"""Height from which heads are searched, m."""


class SplitLimits(NamedTuple):
    """Sizes that decide on splits of a cluster, m."""

    heads_from: float
    """Width from which heads are searched."""
    heads_to: float
    """Width up to which heads are searched."""
    runs_from: float
    """Width from which a cluster is split into runs: that of one person."""
    gap: float
    """Least gap between objects."""
    gap_growth: float
    """Growth of that gap per metre of distance."""


@njit(**CACHED)
def skyline(points: Floats) -> Floats:
    """Distance of the nearest point (q, 2) in each direction, +inf without one; (720,)."""
    out = np.full(_DIRECTIONS, np.inf)
    for i in range(points.shape[0]):
        d = _direction(points[i, 0], points[i, 1])
        out[d] = min(out[d], math.hypot(points[i, 0], points[i, 1]))
    return out


@callee()
def _direction(x: float, y: float) -> int:
    return int((math.atan2(y, x) / (2.0 * math.pi) + 0.5) * _DIRECTIONS) % _DIRECTIONS


@njit(**CACHED)
def split_clusters(
    points: Floats,
    highest: Floats,
    labels: Integers,
    line: Floats,
    limits: SplitLimits,
) -> Integers:
    """Split clusters that are wider than one person: segments (q,) from 0, −1: none.

    A wide cluster is split into runs that lie side by side at about the same distance, and a run
    between two heads.

    Args:
        points: (q, 2) from the sensor, m.
        highest: (q,) of each above the ground, m.
        labels: (q,) cluster of each, −1: none.
        line: the ``skyline``.
        limits: sizes that decide on splits.
    """
    out = np.full(labels.size, -1, dtype=np.int64)
    if labels.size == 0:
        return out
    count = 0
    clusters = labels.max() + 1
    order, first = members_by_label(labels, clusters)
    for cluster in range(clusters):
        members = order[first[cluster] : first[cluster + 1]]
        if _extent(points[members]) <= limits.runs_from:
            count = _split_run(points, highest, members, limits, out, count)
            continue
        # Side by side from the right to the left, without what is seen over a shoulder.
        members = members[stable_order(_bearings(points[members]))]
        members = members[_unobstructed(points[members], line)]
        start = 0
        for k in range(1, members.size + 1):
            last = k == members.size
            if last or _is_separate(points[members[k - 1]], points[members[k]], limits):
                count = _split_run(points, highest, members[start:k], limits, out, count)
                start = k
    return out


@callee()
def _extent(points: Floats) -> float:
    """The largest side of the box about points (m, 2), over four directions of its axes, m."""
    widest = 0.0
    for k in range(4):
        c, s = math.cos(0.25 * math.pi * k), math.sin(0.25 * math.pi * k)
        along = c * points[:, 0] + s * points[:, 1]
        widest = max(widest, along.max() - along.min())
    return widest


@callee()
def _bearings(points: Floats) -> Floats:
    """Directions of points relative to that of their mean, rad."""
    middle = math.atan2(points[:, 1].mean(), points[:, 0].mean())
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        turn = math.atan2(points[i, 1], points[i, 0]) - middle
        out[i] = turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    return out


@callee()
def _unobstructed(points: Floats, line: Floats) -> Booleans:
    """Mask of the points (m, 2) that nothing occludes; the others were seen over a shoulder."""
    out = np.empty(points.shape[0], dtype=np.bool_)
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        out[i] = math.hypot(x, y) <= line[_direction(x, y)] + _OCCLUSION_STEP
    return out


@callee()
def _is_separate(a: Floats, b: Floats, limits: SplitLimits) -> bool:
    """Check that neighbours in bearing belong to different objects."""
    far_a, far_b = math.hypot(a[0], a[1]), math.hypot(b[0], b[1])
    gap = math.hypot(a[0] - b[0], a[1] - b[1])
    least = 2.0 * (limits.gap + limits.gap_growth * far_a)
    separate: bool = abs(far_a - far_b) > _OCCLUSION_STEP or gap > least
    return separate


@callee()
def _split_run(
    points: Floats,
    highest: Floats,
    run: Integers,
    limits: SplitLimits,
    out: Integers,
    count: int,
) -> int:
    """Split a run between heads; number the parts in ``out`` from ``count`` on.

    Returns the next number. Runs wider than ``heads_to`` remain whole.
    """
    todo = np.empty((run.size + 1, 2), dtype=np.int64)
    todo[0, 0], todo[0, 1], left = 0, run.size, int(run.size > 0)
    run = run.copy()
    while left > 0:
        left -= 1
        start, stop = todo[left, 0], todo[left, 1]
        part = run[start:stop]
        width = _extent(points[part])
        at = 0
        if limits.heads_from < width <= limits.heads_to and part.size >= 4:
            order, at = _between_heads(points[part], highest[part], limits)
            run[start:stop] = part[order]
        if at > 0:
            todo[left, 0], todo[left, 1] = start, start + at
            todo[left + 1, 0], todo[left + 1, 1] = start + at, stop
            left += 2
            continue
        out[run[start:stop]] = count
        count += 1
    return count


@callee()
def _between_heads(points: Floats, highest: Floats, limits: SplitLimits) -> tuple[Integers, int]:
    """(order along the line between the outermost heads, number of points before the widest gap).

    The number is 0, and the order unchanged, for one head or none. Several heights are tried, since
    rings may have hit only shoulders.
    """
    top = highest.max()
    order = np.arange(points.shape[0])
    if top < _MIN_HEIGHT:
        return order, 0
    for share in _HEAD_SHARES:
        heads = np.flatnonzero(highest > share * top)
        a, b, widest = _outermost(points, heads)
        if widest < _HEAD_WIDTH:
            return order, 0
        ux, uy = (points[b, 0] - points[a, 0]) / widest, (points[b, 1] - points[a, 1]) / widest
        along = ux * points[:, 0] + uy * points[:, 1]
        at = np.sort(along[heads])
        gaps = at[1:] - at[:-1]
        k = int(np.argmax(gaps))
        if gaps[k] > limits.gap + limits.gap_growth * math.hypot(points[a, 0], points[a, 1]):
            order = stable_order(along)
            return order, int((along < 0.5 * (at[k] + at[k + 1])).sum())
    return order, 0


@callee()
def _outermost(points: Floats, which: Integers) -> tuple[int, int, float]:
    """Indices of the two selected points that are farthest apart, and their distance, m."""
    a, b, widest = 0, 0, 0.0
    for i in which:
        for j in which:
            d = math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])
            if d > widest:
                a, b, widest = i, j, d
    return a, b, widest
