"""Overlap of two routes, obstacles between them, and self-crossing of a route."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.geometry import nearest_on_polyline, resample
from cohelm.kernels import CACHED
from cohelm.planning.costmap.patch import INSCRIBED
from cohelm.planning.problem import PreparedProblem

_SPACING = 0.2  # m between samples of lines


def overlap(a: Floats, b: Floats, corridor: float) -> float:
    """Share of a line's length that lies within ``corridor`` of another; the larger of both.

    Args:
        a, b: lines (k, 2) and (m, 2), m.
        corridor: m.
    """
    a, b = resample(a, _SPACING), resample(b, _SPACING)
    return max(_share_near(a, b, corridor), _share_near(b, a, corridor))


def between(prepared: PreparedProblem, a: Floats, b: Floats) -> float:
    """Length of the largest obstacle between two lines (k, 2) and (m, 2), m; 0 if there is none.

    The length is the longer side of its bounding box. Obstacles are the cells that the centre of
    the inscribed circle cannot enter, so obstacles without a passage between them count as one.
    """
    cost, grid = prepared.costmap.cost, prepared.costmap.grid
    cells = grid.cells(np.concatenate([a, b[::-1]]))
    cells = np.clip(cells, 0, np.array(cost.shape) - 1)
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    enclosed = np.zeros(high - low, dtype=np.uint8)
    cv2.fillPoly(enclosed, [(cells - low)[:, ::-1].astype(np.int32)], 1)
    enclosed &= cost[low[0] : high[0], low[1] : high[1]] >= INSCRIBED
    _, _, boxes, _ = cv2.connectedComponentsWithStats(enclosed)
    sides = boxes[1:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    return float(sides.max(initial=0)) * grid.resolution


@njit(**CACHED)
def comes_back(line: Floats, radius: float) -> bool:
    """Check that a line (k, 2) returns to a place where it has been, with no obstacle between.

    Points closer than twice the blocked radius have no obstacle between them.
    """
    along = np.zeros(line.shape[0])
    for i in range(1, line.shape[0]):
        step = line[i] - line[i - 1]
        along[i] = along[i - 1] + np.hypot(step[0], step[1])
        for j in range(i):
            gap = np.hypot(line[i, 0] - line[j, 0], line[i, 1] - line[j, 1])
            if gap < 1.8 * radius and along[i] - along[j] > 6.0 * radius:
                return True
    return False


@njit(**CACHED)
def _share_near(a: Floats, b: Floats, corridor: float) -> float:
    """Share of the points of ``a`` (k, 2) within ``corridor`` of the line ``b`` (m, 2)."""
    near = 0.0
    for i in range(a.shape[0]):
        near += nearest_on_polyline(b, a[i, 0], a[i, 1])[1] <= corridor
    return near / float(a.shape[0])
