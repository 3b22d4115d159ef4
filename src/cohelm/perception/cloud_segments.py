"""Columns of one cluster cut apart where several things touch: people, and what they stand at."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.perception.fits import clutter_evidence, disc_evidence, fit_disc, flat_evidence

_DIRECTIONS = 720
"""Round the horizon, for what stands in front of what (0.5° each)."""
_BEFORE = 0.25
"""What is nearer by this, in the same direction, stands before another thing, m."""
_HEADS_FROM, _HEADS_APART = (0.86, 0.89, 0.92, 0.95), 0.3
"""A head is what reaches above one of these shares of the top (shoulders are at 0.82 of a body's
height, Drillis and Contini 1966); two have their outer sides at least so far apart, m."""
_SMALLEST = 1.1
"""Height from which heads are looked for, m."""
_SURER = 8.0
"""By how much −2 log-evidence must fall for a cut."""


@njit(cache=True)
def skyline(points: Floats) -> Floats:
    """Distance of the nearest point (q, 2) in each direction, +inf without any; (720,)."""
    out = np.full(_DIRECTIONS, np.inf)
    for i in range(points.shape[0]):
        d = _direction(points[i, 0], points[i, 1])
        out[d] = min(out[d], math.hypot(points[i, 0], points[i, 1]))
    return out


@njit(cache=True)
def _direction(x: float, y: float) -> int:
    return int((math.atan2(y, x) / (2.0 * math.pi) + 0.5) * _DIRECTIONS) % _DIRECTIONS


@njit(cache=True)
def hidden_ends(points: Floats, line: Floats) -> tuple[bool, bool]:
    """Whether something nearer hides the right (clockwise) and the left end of a thing (m, 2).

    Args:
        points: of the thing.
        line: the ``skyline``.
    """
    x, y = points[:, 0].mean(), points[:, 1].mean()
    away, middle = math.hypot(x, y), math.atan2(y, x)
    low, high = 0.0, 0.0
    for i in range(points.shape[0]):
        turn = math.atan2(points[i, 1], points[i, 0]) - middle
        turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
        low, high = min(low, turn), max(high, turn)
    near = away - _BEFORE
    right = left = False
    for k in range(1, 4):
        step = k * 2.0 * math.pi / _DIRECTIONS
        right |= line[_at(middle + low - step)] < near
        left |= line[_at(middle + high + step)] < near
    return right, left


@njit(cache=True)
def _at(angle: float) -> int:
    return math.floor((angle / (2.0 * math.pi) + 0.5) * _DIRECTIONS) % _DIRECTIONS


@njit(cache=True)
def segments(  # a kernel takes arrays and numbers
    points: Floats,
    highest: Floats,
    labels: Integers,
    line: Floats,
    sizes: Floats,
    body: Floats,
) -> Integers:
    """Clusters cut where they are wider than one person: (q,) numbers from 0, −1: none.

    A wide one falls into runs that lie side by side at about the same distance; a run falls
    between two heads, and where two bodies explain it better than one thing does.

    Args:
        points: (q, 2) from the sensor, m.
        highest: (q,) of each above the ground, m.
        labels: (q,) cluster of each, −1: none.
        line: the ``skyline``.
        sizes: (width from which heads are looked for, width from which bodies are, width up to
            which they are, least gap between things, its growth per metre away), m.
        body: (r₀, σ_r, σ) of a body's disc, m.
    """
    out = np.full(labels.size, -1, dtype=np.int64)
    if labels.size == 0:
        return out
    count = 0
    order = np.argsort(labels, kind="mergesort")
    first = np.searchsorted(labels[order], np.arange(labels.max() + 2))
    for cluster in range(labels.max() + 1):
        members = order[first[cluster] : first[cluster + 1]]
        if extent(points[members]) <= sizes[1]:
            count = _cut(points, highest, members, sizes, body, out, count)
            continue
        members = members[np.argsort(_bearings(points[members]), kind="mergesort")]
        start = 0
        members = members[_unobstructed(points[members], line)]
        for k in range(1, members.size + 1):
            if k == members.size or _apart(points[members[k - 1]], points[members[k]], sizes):
                count = _cut(points, highest, members[start:k], sizes, body, out, count)
                start = k
    return out


@njit(cache=True)
def extent(points: Floats) -> float:
    """The largest side of the box about points (m, 2), over four directions of its axes, m."""
    widest = 0.0
    for k in range(4):
        c, s = math.cos(0.25 * math.pi * k), math.sin(0.25 * math.pi * k)
        along = c * points[:, 0] + s * points[:, 1]
        widest = max(widest, along.max() - along.min())
    return widest


@njit(cache=True)
def _bearings(points: Floats) -> Floats:
    """Directions of points, rad, about that of their mean."""
    middle = math.atan2(points[:, 1].mean(), points[:, 0].mean())
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        turn = math.atan2(points[i, 1], points[i, 0]) - middle
        out[i] = turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    return out


@njit(cache=True)
def _unobstructed(points: Floats, line: Floats) -> Booleans:
    """Which points (m, 2) nothing stands before; others were seen over a shoulder."""
    out = np.empty(points.shape[0], dtype=np.bool_)
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        out[i] = math.hypot(x, y) <= line[_direction(x, y)] + _BEFORE
    return out


@njit(cache=True)
def _apart(a: Floats, b: Floats, sizes: Floats) -> bool:
    """Whether neighbours in bearing belong to different things."""
    far_a, far_b = math.hypot(a[0], a[1]), math.hypot(b[0], b[1])
    gap = math.hypot(a[0] - b[0], a[1] - b[1])
    apart: bool = abs(far_a - far_b) > _BEFORE or gap > 2.0 * (sizes[3] + sizes[4] * far_a)
    return apart


@njit(cache=True)
def _cut(  # noqa: PLR0917  # a kernel takes arrays and numbers
    points: Floats,
    highest: Floats,
    run: Integers,
    sizes: Floats,
    body: Floats,
    out: Integers,
    count: int,
) -> int:
    """Number a run, in the parts that heads or bodies make of it, from ``count``; the next number.

    Runs of more than ``sizes[2]`` stay whole, unless heads part them.
    """
    todo = np.empty((run.size + 1, 2), dtype=np.int64)
    todo[0, 0], todo[0, 1], left = 0, run.size, int(run.size > 0)
    run = run.copy()
    while left > 0:
        left -= 1
        start, stop = todo[left, 0], todo[left, 1]
        part = run[start:stop]
        width = extent(points[part])
        at = 0
        if sizes[0] < width <= sizes[2] and part.size >= 4:
            order, at = _between_heads(points[part], highest[part], sizes)
            run[start:stop] = part[order]
            if at == 0 and width > sizes[1]:
                at = _between_bodies(points[run[start:stop]], body)
        if at > 0:
            todo[left, 0], todo[left, 1] = start, start + at
            todo[left + 1, 0], todo[left + 1, 1] = start + at, stop
            left += 2
            continue
        out[run[start:stop]] = count
        count += 1
    return count


@njit(cache=True)
def _between_heads(points: Floats, highest: Floats, sizes: Floats) -> tuple[Integers, int]:
    """(order along the line between the outermost heads, how many lie before the widest gap).

    0 of them, and the order unchanged, where there is but one head or none. Whether rings met heads
    or only shoulders is not known, so that several heights are tried.
    """
    top = highest.max()
    order = np.arange(points.shape[0])
    if top < _SMALLEST:
        return order, 0
    for share in _HEADS_FROM:
        heads = np.flatnonzero(highest > share * top)
        a, b, widest = _outermost(points, heads)
        if widest < _HEADS_APART:
            return order, 0
        ux, uy = (points[b, 0] - points[a, 0]) / widest, (points[b, 1] - points[a, 1]) / widest
        along = ux * points[:, 0] + uy * points[:, 1]
        at = np.sort(along[heads])
        gaps = at[1:] - at[:-1]
        k = int(np.argmax(gaps))
        if gaps[k] > sizes[3] + sizes[4] * math.hypot(points[a, 0], points[a, 1]):
            order = np.argsort(along, kind="mergesort")
            return order, int((along < 0.5 * (at[k] + at[k + 1])).sum())
    return order, 0


@njit(cache=True)
def _outermost(points: Floats, which: Integers) -> tuple[int, int, float]:
    """The two of some points that lie farthest apart, and how far, m."""
    a, b, widest = 0, 0, 0.0
    for i in which:
        for j in which:
            d = math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])
            if d > widest:
                a, b, widest = i, j, d
    return a, b, widest


@njit(cache=True)
def _between_bodies(points: Floats, body: Floats) -> int:
    """Where two bodies touch in a run; 0 where one thing explains it as well."""
    m, origin = points.shape[0], np.zeros(2)
    _, _, _, misfit, _ = fit_disc(points, origin, body[0], body[1], body[2])
    single = min(disc_evidence(misfit, m), clutter_evidence(misfit, m))
    best, where = min(single, flat_evidence(points, body[2])) - _SURER, 0
    for cut in range(2, m - 1, max(1, m // 24)):
        _, _, _, a, _ = fit_disc(points[:cut], origin, body[0], body[1], body[2])
        _, _, _, b, _ = fit_disc(points[cut:], origin, body[0], body[1], body[2])
        both = a + b + 5.0 * math.log(m)
        if both < best:
            best, where = both, cut
    return where
