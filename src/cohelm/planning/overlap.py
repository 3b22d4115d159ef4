"""How far two routes are the same, what stands between them, and whether one crosses itself."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.geometry import nearest_on_polyline, resample
from cohelm.planning.cost_values import INSCRIBED
from cohelm.planning.ground import Ground

_SPACING = 0.2  # m between the places at which lines are compared


def overlap(a: Floats, b: Floats, corridor: float) -> float:
    """The share of a line's length that lies within ``corridor`` of another; of both, the larger.

    Args:
        a, b: lines (k, 2) and (m, 2), m.
        corridor: m.
    """
    a, b = resample(a, _SPACING), resample(b, _SPACING)
    return max(_share_near(a, b, corridor), _share_near(b, a, corridor))


def between(ground: Ground, a: Floats, b: Floats) -> float:
    """How long the largest obstacle between two lines (k, 2) and (m, 2) is, m; 0 where none is.

    The longer side of its bounding box. Obstacles are what the robot's inscribed circle cannot
    enter, so they are grown by its radius, and one where it does not fit through.
    """
    cost, grid = ground.costmap.cost, ground.costmap.grid
    cells = grid.cells(np.concatenate([a, b[::-1]]))
    cells = np.clip(cells, 0, np.array(cost.shape) - 1)
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    enclosed = np.zeros(high - low, dtype=np.uint8)
    cv2.fillPoly(enclosed, [(cells - low)[:, ::-1].astype(np.int32)], 1)
    enclosed &= cost[low[0] : high[0], low[1] : high[1]] >= INSCRIBED
    _, _, boxes, _ = cv2.connectedComponentsWithStats(enclosed)
    sides = boxes[1:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    return float(sides.max(initial=0)) * grid.resolution


@njit(cache=True)
def comes_back(line: Floats, radius: float) -> bool:
    """Whether a line (k, 2) comes back to a place it has been at, with nothing between.

    What is nearer than twice the radius that is kept from obstacles has none between.
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


@njit(cache=True)
def _share_near(a: Floats, b: Floats, corridor: float) -> float:
    """The share of the points of ``a`` (k, 2) within ``corridor`` of the line ``b`` (m, 2)."""
    near = 0.0
    for i in range(a.shape[0]):
        near += nearest_on_polyline(b, a[i, 0], a[i, 1])[1] <= corridor
    return near / float(a.shape[0])
