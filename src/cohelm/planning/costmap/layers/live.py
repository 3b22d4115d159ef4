"""Live layer: detected obstacles that are not on the map, in a window of the map's cells."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats32
from cohelm.maps import OccupancyGrid, signed_distance
from cohelm.messages import LiveObstacles
from cohelm.planning.costmap.layers.inflation import Inflation, inflate
from cohelm.planning.costmap.patch import Patch


def live_patch(
    live: LiveObstacles, grid: OccupancyGrid, radius: float, inflation: Inflation
) -> Patch | None:
    """Patch of the live obstacles with their inflation; None if it does not touch the grid.

    Args:
        live: the obstacles.
        grid: the map.
        radius: cells closer than this to an obstacle's surface are blocked, m.
        inflation: decay of the costs beyond.
    """
    if not live.occupied.any():
        return None
    rows, cols = reach_of(live, inflation.reach(radius), grid)
    if rows.start >= rows.stop or cols.start >= cols.stop:
        return None
    clearance = live_clearance(live, rows, cols, grid.resolution)
    cost = inflate(clearance, radius, inflation)
    return Patch(rows=rows, cols=cols, cost=cost, clearance=clearance, rule=False)


def reach_of(live: LiveObstacles, reach: float, grid: OccupancyGrid) -> tuple[slice, slice]:
    """Rows and columns of ``grid`` within ``reach`` (m) of the live window; may be empty."""
    pad = math.ceil(reach / grid.resolution) + 1
    low = live.corner - pad
    high = live.corner + np.array(live.occupied.shape) + pad
    (r0, c0), (r1, c1) = np.maximum(low, 0), np.minimum(high, np.array(grid.shape))
    return slice(int(r0), int(r1)), slice(int(c0), int(c1))


def live_clearance(live: LiveObstacles, rows: slice, cols: slice, resolution: float) -> Floats32:
    """Signed distance to the surface of the live obstacles in a non-empty window of the grid, m.

    Obstacles of the live window that lie off the grid count too.
    """
    top, left = live.corner
    height, width = live.occupied.shape
    r0, c0 = min(rows.start, top), min(cols.start, left)
    r1, c1 = max(rows.stop, top + height), max(cols.stop, left + width)
    blocked = np.zeros((r1 - r0, c1 - c0), dtype=np.bool_)
    blocked[top - r0 : top - r0 + height, left - c0 : left - c0 + width] = live.occupied > 0
    distance = signed_distance(blocked, resolution)
    return distance[rows.start - r0 : rows.stop - r0, cols.start - c0 : cols.stop - c0]
