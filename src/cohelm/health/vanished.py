"""Objects that stood free in a sweep and are nowhere in the next ones.

A scanner that goes blind in a sector, and reads it as free, shows an open floor: no map contradicts
it where the walls are out of reach. But whoever stood there cannot be gone. An object counts if it
stands free and near, so that several beams meet it; it has vanished if beams pass through its place
and all places that it could have reached, and nothing hides them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.geometry import inverse, transform
from cohelm.kernels import CACHED

_FAR = 6.0
"""Distance up to which an object counts, m: farther ones return few beams."""
_NEAR = 0.8
"""Distance below which none counts, m: the chair's own parts and who leans on it."""
_BEAMS = 4
_STEP = 0.3
"""Largest step of the range between neighbouring beams of one object, m."""
_FREE = 0.5
"""Distance from its edges to what lies behind them, m."""
_WIDTH = (0.15, 1.0)
"""Of an object, m."""
_REACH = 0.9
"""Distance that it can move between some sweeps, and half its width, m."""
_KEPT = 1.2
"""Time since it was last seen whole for which it is remembered, s: so long takes a walker into a
blind sector."""
_CONFIRMED = 0.09
"""Time for which it must be gone, s: two sweeps."""
_PRESENT, _GONE, _HIDDEN = 0, 1, 2


class FreeObjects(NamedTuple):
    """Objects of the last sweeps."""

    rows: Floats
    """(n, 4): x, y in the odometry frame, m; time when it was last seen whole, and time since when
    it is gone, s, NaN: it is not."""

    def vanished(self, time: float) -> bool:
        """Check whether one is gone for long enough at a time, s."""
        return bool((time - self.rows[:, 3] >= _CONFIRMED - 1e-9).any())


NO_OBJECTS = FreeObjects(np.zeros((0, 4)))


def update_free_objects(
    before: FreeObjects, ranges: Floats, first: float, increment: float, X_OS: Floats, time: float
) -> FreeObjects:
    """Look for the objects of the last sweeps in a new one, and add its own.

    Args:
        before: objects of the last sweeps.
        ranges: of the new sweep (b,), m; +inf: free.
        first, increment: direction of the first beam and step to the next, rad.
        X_OS: pose (3,) of the scanner in the odometry frame.
        time: of the sweep, s.
    """
    known = before.rows[time - before.rows[:, 2] <= _KEPT]
    places = transform(inverse(X_OS), known[:, :2]) if len(known) else known[:, :2]
    found = _free_objects(ranges, first, increment)
    out = [np.array([*transform(X_OS, each), time, math.nan]) for each in found]
    for row, place in zip(known, places, strict=True):
        state, x, y = _look(ranges, first, increment, place[0], place[1])
        if state == _GONE:
            out.append(np.array([*row[:3], time if math.isnan(row[3]) else row[3]]))
        elif state == _PRESENT and not _is_near(found, place):
            out.append(np.array([*transform(X_OS, np.array([x, y])), row[2], math.nan]))
    return FreeObjects(np.array(out)) if out else NO_OBJECTS


def _is_near(found: Floats, place: Floats) -> bool:
    return len(found) > 0 and bool(np.hypot(*(found - place).T).min() < _REACH)


@njit(**CACHED)
def _free_objects(ranges: Floats, first: float, increment: float) -> Floats:
    """Centres (n, 2) of the objects that stand free, in the scanner's frame, m."""
    b = len(ranges)
    out, n = np.empty((b, 2)), 0
    start = 0
    while start < b and _joined(ranges, start - 1, start):
        start += 1
    k = 0
    while k < b and start < b:
        i, length = (start + k) % b, 1
        if not 0.05 < ranges[i] < _FAR:
            k += 1
            continue
        while k + length < b and _joined(ranges, (i + length - 1) % b, (i + length) % b):
            length += 1
        last = (i + length - 1) % b
        behind = min(ranges[i - 1] - ranges[i], ranges[(last + 1) % b] - ranges[last])
        width = ranges[i] * abs(increment) * (length - 1)
        if length >= _BEAMS and _WIDTH[0] < width < _WIDTH[1] and behind > _FREE:
            x, y = 0.0, 0.0
            for j in range(length):
                a, r = first + increment * ((i + j) % b), ranges[(i + j) % b]
                x, y = x + r * math.cos(a) / length, y + r * math.sin(a) / length
            out[n, 0], out[n, 1] = x, y
            n += 1
        k += length
    return out[:n]


@njit(**CACHED)
def _joined(ranges: Floats, i: int, j: int) -> bool:
    """Check that two neighbouring beams meet one object."""
    one, other = ranges[i], ranges[j]
    returned: bool = 0.05 < one < 1e3 and 0.05 < other < 1e3
    return returned and bool(abs(one - other) < _STEP)


@njit(**CACHED)
def _look(
    ranges: Floats, first: float, increment: float, x: float, y: float
) -> tuple[int, float, float]:
    """State of an object that was at a place of the scanner's frame, and its place now, m."""
    far, beams, returns, at_x, at_y = math.hypot(x, y), 0, 0, 0.0, 0.0
    if far < _NEAR:
        return _HIDDEN, x, y
    half, middle = math.atan2(_REACH, far), math.atan2(y, x)
    for i in range(len(ranges)):
        a, r = first + increment * i, ranges[i]
        if abs((a - middle + math.pi) % (2.0 * math.pi) - math.pi) > half:
            continue
        beams += 1
        if not r > 0.05 or r < far - _REACH:
            return _HIDDEN, x, y
        px, py = r * math.cos(a), r * math.sin(a)
        if r < 1e3 and math.hypot(px - x, py - y) < _REACH:
            returns, at_x, at_y = returns + 1, at_x + px, at_y + py
    if returns:
        return _PRESENT, at_x / returns, at_y / returns
    whole = beams * abs(increment) >= 2.0 * half - 2.0 * abs(increment)
    return (_GONE if whole and beams >= _BEAMS else _HIDDEN), x, y
