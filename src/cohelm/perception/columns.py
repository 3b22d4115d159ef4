"""A cloud thinned to upright columns: where something stands, and from what height to what."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers

LAYER = 0.1
"""Height of the slices whose occupancy a column keeps, m."""
LAYERS = 30
_GRAIN = 1e-4
"""Coordinates are summed as whole multiples of this, m, so that their order cannot matter."""


class Columns(NamedTuple):
    """q columns, by the cells of a square grid about the sensor, row by row."""

    centre: Floats
    """(q, 2), mean of the returns, m."""
    returns: Integers
    """(q,), how many."""
    lowest: Floats
    """(q,), height above the ground, m; so is the next."""
    highest: Floats
    """(q,); of what is in the way."""
    layers: Integers
    """(q,), bit k: something came back from ``LAYER``·k to ``LAYER``·(k + 1) above the ground."""
    first: Integers
    """(q,), the same of what came back to the first sensor."""

    def where(self, which: Booleans) -> Columns:
        """Those that ``which`` (q,) says."""
        return Columns(
            self.centre[which],
            self.returns[which],
            self.lowest[which],
            self.highest[which],
            self.layers[which],
            self.first[which],
        )


@njit(cache=True)
def thin(  # a kernel takes arrays and numbers
    points: Floats, heights: Floats, kept: Floats, side: float, reach: float, first: int
) -> tuple[Floats, Integers, Floats, Floats, Integers, Integers]:
    """The fields of :class:`Columns` for the points whose height lies within ``kept``.

    Args:
        points: (p, 2 or more), x and y from the sensor, none farther than ``reach``, m.
        heights: (p,) above the ground, m.
        kept: (hole, ground, its growth with distance, clearance, highest): what is from the ground
            to the highest, and what is below a hole, m; ``highest`` of a column is told of what
            is lower than the clearance, where there is any.
        side: of a column, m.
        reach: m.
        first: how many points, the first of them, are the first sensor's.
    """
    n = points.shape[0]
    cells = int(2.0 * reach / side) + 2
    index = np.full(cells * cells, -1, dtype=np.int32)
    cell = np.full(n, -1, dtype=np.int64)
    used = np.zeros(cells * cells, dtype=np.bool_)
    for i in range(n):
        h = heights[i]
        x, y = points[i, 0], points[i, 1]
        if (kept[1] < h <= kept[4] and h > kept[1] + kept[2] * math.sqrt(x * x + y * y)) or (
            h < kept[0]
        ):
            row = int((points[i, 1] + reach) / side)
            c = row * cells + int((points[i, 0] + reach) / side)
            cell[i] = c
            used[c] = True
    q = 0
    for c in range(cells * cells):
        if used[c]:
            index[c] = q
            q += 1
    sums = np.zeros((q, 2), dtype=np.int64)
    count = np.zeros(q, dtype=np.int64)
    lowest, highest = np.full(q, np.inf), np.full(q, -np.inf)
    layers, by_first = np.zeros(q, dtype=np.int64), np.zeros(q, dtype=np.int64)
    for i in range(n):
        if cell[i] < 0:
            continue
        k, h = index[cell[i]], heights[i]
        sums[k, 0] += math.floor(points[i, 0] / _GRAIN + 0.5)
        sums[k, 1] += math.floor(points[i, 1] / _GRAIN + 0.5)
        count[k] += 1
        lowest[k] = min(lowest[k], h)
        if h <= kept[3]:
            highest[k] = max(highest[k], h)
        bit = 1 << min(max(int(h / LAYER), 0), LAYERS - 1)
        layers[k] |= bit
        if i < first:
            by_first[k] |= bit
    centre = np.empty((q, 2))
    for k in range(q):
        centre[k, 0] = sums[k, 0] * _GRAIN / count[k]
        centre[k, 1] = sums[k, 1] * _GRAIN / count[k]
    return centre, count, lowest, highest, layers, by_first
