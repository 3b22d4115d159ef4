"""Upright columns: a cloud reduced to the cells of a grid, with the lowest and highest return."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cohelm.array_kernels import members_by_label
from cohelm.arrays import Booleans, Bytes, Floats, Floats32, Integers
from cohelm.kernels import CACHED, callee

LAYER = 0.1
"""Height of the slices whose occupancy a column stores, m."""
LAYERS = 30
_GRAIN = 1e-4
"""Coordinates are summed as integer multiples of this, m, so that their order does not matter."""


class Columns(NamedTuple):
    """q columns, by the cells of a square grid about the sensor, row by row."""

    centre: Floats
    """(q, 2), mean of the returns, m."""
    returns: Integers
    """(q,), number of returns."""
    lowest: Floats
    """(q,), height above the ground, m."""
    highest: Floats
    """(q,), height above the ground below the clearance, m."""
    occupied_layers: Integers
    """(q,), bit k: there is a return from ``LAYER``·k to ``LAYER``·(k + 1) above the ground."""
    first_sensor_layers: Integers
    """(q,), the same of the first sensor's returns only."""

    def where(self, which: Booleans) -> Columns:
        """Select the columns of a mask (q,)."""
        return Columns._make(field[which] for field in self)


class HeightLimits(NamedTuple):
    """Heights above the ground, m; returns from ``ground`` to ``top`` or below ``hole`` count."""

    hole: float
    ground: float
    ground_growth: float
    """Growth of ``ground`` with distance, m/m."""
    clearance: float
    """``Columns.highest`` covers returns below this, if there are any."""
    top: float


@njit(**CACHED)
def build_columns(
    points: Floats,
    heights: Floats,
    limits: HeightLimits,
    side: float,
    reach: float,
    first_sensor_count: int,
) -> Columns:
    """Build the columns of points whose height lies within ``limits``.

    Args:
        points: (p, 2 or more), x and y from the sensor, none farther than ``reach``, m.
        heights: (p,) above the ground, m.
        limits: heights that count.
        side: of a column, m.
        reach: m.
        first_sensor_count: number of leading points that are the first sensor's.
    """
    q, cell, column = _number_columns(points, heights, limits, side, reach)
    # Sums and extremes of each column.
    sums = np.zeros((q, 2), dtype=np.int64)
    count = np.zeros(q, dtype=np.int64)
    lowest, highest = np.full(q, np.inf), np.full(q, -np.inf)
    layers, by_first = np.zeros(q, dtype=np.int64), np.zeros(q, dtype=np.int64)
    for i in range(points.shape[0]):
        if cell[i] < 0:
            continue
        k, h = column[cell[i]], heights[i]
        sums[k, 0] += math.floor(points[i, 0] / _GRAIN + 0.5)
        sums[k, 1] += math.floor(points[i, 1] / _GRAIN + 0.5)
        count[k] += 1
        lowest[k] = min(lowest[k], h)
        if h <= limits.clearance:
            highest[k] = max(highest[k], h)
        bit = 1 << min(max(int(h / LAYER), 0), LAYERS - 1)
        layers[k] |= bit
        if i < first_sensor_count:
            by_first[k] |= bit
    centre = np.empty((q, 2))
    for k in range(q):
        centre[k, 0] = sums[k, 0] * _GRAIN / count[k]
        centre[k, 1] = sums[k, 1] * _GRAIN / count[k]
    return Columns(centre, count, lowest, highest, layers, by_first)


@callee()
def _number_columns(
    points: Floats, heights: Floats, limits: HeightLimits, side: float, reach: float
) -> tuple[int, Integers, NDArray[np.int32]]:
    """Number the cells of points that count row by row.

    Returns:
        Number of columns; cell (p,) of each point; column of each cell (c,); −1: none.
    """
    cells = int(2.0 * reach / side) + 2
    cell = np.full(points.shape[0], -1, dtype=np.int64)
    column = np.full(cells * cells, -1, dtype=np.int32)
    used = np.zeros(cells * cells, dtype=np.bool_)
    ground, growth = limits.ground, limits.ground_growth
    for i in range(points.shape[0]):
        h, x, y = heights[i], points[i, 0], points[i, 1]
        if (ground < h <= limits.top and h > ground + growth * math.sqrt(x * x + y * y)) or (
            h < limits.hole
        ):
            c = int((y + reach) / side) * cells + int((x + reach) / side)
            cell[i] = c
            used[c] = True
    q = 0
    for c in range(cells * cells):
        if used[c]:
            column[c] = q
            q += 1
    return q, cell, column


@njit(**CACHED)
def floor_places(
    points: Floats, ground: Booleans, parts: Integers, side: float
) -> tuple[Floats32, Bytes]:
    """Find the observed floor: one place per sensor and square, (f, 2), and the sensor, (f,).

    Args:
        points: (p, 3) from the first sensor, m; sensor after sensor.
        ground: (p,) True for floor.
        parts: (s + 1,) first return of each sensor, and the end of the last.
        side: of a square, m.
    """
    reach = 0.0
    for i in range(points.shape[0]):
        if ground[i]:
            reach = max(reach, abs(points[i, 0]), abs(points[i, 1]))
    cells = int(2.0 * reach / side) + 2
    last_sensor = np.full(cells * cells, -1, dtype=np.int16)
    place = np.empty((points.shape[0], 2), dtype=np.float32)
    sensor = np.empty(points.shape[0], np.uint8)
    count = 0
    for s in range(parts.size - 1):
        for i in range(parts[s], parts[s + 1]):
            if not ground[i]:
                continue
            row, col = int((points[i, 1] + reach) / side), int((points[i, 0] + reach) / side)
            if last_sensor[row * cells + col] != s:
                last_sensor[row * cells + col] = s
                place[count, 0], place[count, 1] = points[i, 0], points[i, 1]
                sensor[count] = s
                count += 1
    return place[:count].copy(), sensor[:count].copy()


class _Squares(NamedTuple):
    """Columns sorted into squares of a grid with an empty border."""

    columns: Integers
    """Indices of columns, square by square."""
    start: Integers
    """First of each square in ``columns``."""
    n_cols: int
    """Squares in a row of the grid."""


@njit(**CACHED)
def touching_share(
    centre: Floats, labels: Integers, counted: Booleans, near: float, segments: int
) -> Floats:
    """Compute the share of each segment's columns that are near another object; (segments,).

    Args:
        centre: (q, 2) m.
        labels: (q,) segment of each; ``segments`` and more, or −1, is another object.
        counted: (q,) mask of the columns that count.
        near: distance of columns that touch, m.
        segments: number of segments.
    """
    size, met = np.zeros(segments), np.zeros(segments)
    chosen = np.flatnonzero(counted)
    if chosen.size == 0:
        return size
    # With squares of side ``near``, all neighbours lie in the 3 × 3 squares about a column.
    left, low = centre[chosen, 0].min(), centre[chosen, 1].min()
    rows = int((centre[chosen, 1].max() - low) / near) + 3
    cols = int((centre[chosen, 0].max() - left) / near) + 3
    square = np.empty(chosen.size, dtype=np.int64)
    for a in range(chosen.size):
        row = int((centre[chosen[a], 1] - low) / near) + 1
        square[a] = row * cols + int((centre[chosen[a], 0] - left) / near) + 1
    order, first = members_by_label(square, rows * cols)
    squares = _Squares(chosen[order], first, cols)
    for a in range(chosen.size):
        i = chosen[a]
        if labels[i] < 0 or labels[i] >= segments:
            continue
        size[labels[i]] += 1.0
        met[labels[i]] += _touches_other(centre, labels, squares, i, square[a], near)
    return met / np.maximum(size, 1.0)


@callee()
def _touches_other(
    centre: Floats, labels: Integers, squares: _Squares, i: int, square: int, near: float
) -> bool:
    """Check that another object's column lies within ``near`` of column ``i`` in ``square``."""
    for row in range(-1, 2):
        middle = square + row * squares.n_cols
        for b in range(squares.start[middle - 1], squares.start[middle + 2]):
            j = squares.columns[b]
            if labels[j] != labels[i]:
                apart = math.hypot(centre[j, 0] - centre[i, 0], centre[j, 1] - centre[i, 1])
                if apart <= near:
                    return True
    return False


@njit(**CACHED)
def assign_low_columns(
    centre: Floats, labels: Integers, low: Floats, clusters: Integers, near: float, count: int
) -> Integers:
    """Assign low columns to the body whose legs they are, or to their own cluster.

    A cluster of low columns no wider than ``near`` belongs to the nearest segment, no wider than
    a person, whose mean lies within ``near``; others are numbered from ``count``.

    Args:
        centre: (q, 2) of all columns.
        labels: (q,) segment of each, −1: none.
        low: (k, 2) low columns.
        clusters: (k,) of low columns, −1: none.
        near: m.
        count: number of segments.
    """
    box = _boxes(centre, labels, count)
    groups = clusters.max() + 1 if clusters.size else 0
    low_box = _boxes(low, clusters, groups)
    number = np.arange(count, count + groups)
    for g in range(groups):
        s = low_box[g]
        if max(s[2] - s[0], s[3] - s[1]) > near:
            continue
        best = near
        for k in range(count):
            b = box[k]
            if max(b[2] - b[0], b[3] - b[1]) > 2.0 * near:
                continue
            dx = 0.5 * (s[0] + s[2] - b[0] - b[2])
            dy = 0.5 * (s[1] + s[3] - b[1] - b[3])
            if math.hypot(dx, dy) < best:
                best, number[g] = math.hypot(dx, dy), k
    out = np.full(clusters.size, -1, dtype=np.int64)
    for i in range(clusters.size):
        if clusters[i] >= 0:
            out[i] = number[clusters[i]]
    return out


@callee()
def _boxes(points: Floats, labels: Integers, count: int) -> Floats:
    """Bounding boxes (count, 4) of (min x, min y, max x, max y) of labelled points."""
    box = np.empty((count, 4))
    box[:, :2], box[:, 2:] = np.inf, -np.inf
    for i in range(labels.size):
        if labels[i] >= 0:
            b = box[labels[i]]
            b[0], b[1] = min(b[0], points[i, 0]), min(b[1], points[i, 1])
            b[2], b[3] = max(b[2], points[i, 0]), max(b[3], points[i, 1])
    return box
