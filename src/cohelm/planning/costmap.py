"""The costmap: what it costs to be where, in Nav2's values, as layers combined by maximum.

    0 free    1–252 graded    253 nearer than the robot is wide    254 an obstacle    255 unknown

Unknown blocks a wheelchair, so everything from ``INSCRIBED`` up does. Layers live in ``layers/``,
one file each: a layer is a function that gives costs for a grid or for a window of it.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Bytes, Floats32, Shape, value
from cohelm.maps import OccupancyGrid, signed_distance
from cohelm.messages import LiveObstacles
from cohelm.planning.cost_values import FREE, INSCRIBED, LETHAL, UNKNOWN
from cohelm.planning.layers.inflation import Inflation, inflate
from cohelm.planning.layers.live import live_clearance, reach_of
from cohelm.planning.layers.static import static_costs

__all__ = ["FREE", "INSCRIBED", "LETHAL", "UNKNOWN", "Costmap", "Inflation", "build_costmap"]


@value
class Costmap:
    """Costs and clearances on a grid."""

    grid: OccupancyGrid
    """The static map below; says where the cells are."""
    cost: Annotated[Bytes, Shape("rows cols")]
    """Nav2's values."""
    clearance: Annotated[Floats32, Shape("rows cols")]
    """Distance from cell centres to the surface of what blocks, m; negative inside. Exact in the
    map; about live obstacles exact as far as they inflate."""
    radius: float
    """The distance up to which a cell is blocked, m."""


def build_costmap(
    grid: OccupancyGrid,
    radius: float,
    inflation: Inflation,
    live: LiveObstacles | None = None,
) -> Costmap:
    """The costmap of a map and what stands in it.

    The map's part is kept for the last few (grid, radius, inflation); live obstacles change only
    the window that they inflate into.

    Args:
        grid: the static map.
        radius: cells nearer than this to an obstacle's surface are blocked, m.
        inflation: how costs fall off beyond.
        live: what the sensors see that the map does not know.
    """
    base = _static_costmap(grid, radius, inflation)
    if live is None or not live.occupied.any():
        return base
    rows, cols = reach_of(live, inflation.reach(radius), grid)
    if rows.start >= rows.stop or cols.start >= cols.stop:
        return base
    cost, clearance = base.cost.copy(), base.clearance.copy()
    near = live_clearance(live, rows, cols, grid.resolution)
    clearance[rows, cols] = np.minimum(clearance[rows, cols], near)
    cost[rows, cols] = np.maximum(cost[rows, cols], inflate(near, radius, inflation))
    return _costmap(grid, cost, clearance, radius)


def combine(costmap: Costmap, layer: Bytes) -> Costmap:
    """The costmap with one more layer (rows, cols), by maximum."""
    return _costmap(
        costmap.grid, np.maximum(costmap.cost, layer), costmap.clearance, costmap.radius
    )


@lru_cache(maxsize=4)
def _static_costmap(grid: OccupancyGrid, radius: float, inflation: Inflation) -> Costmap:
    clearance = _static_clearance(grid)
    cost = np.maximum(static_costs(grid), inflate(clearance, radius, inflation))
    return _costmap(grid, cost, clearance, radius)


@lru_cache(maxsize=4)
def _static_clearance(grid: OccupancyGrid) -> Floats32:
    clearance = signed_distance(grid.blocked(), grid.resolution)
    clearance.flags.writeable = False
    return clearance


def _costmap(grid: OccupancyGrid, cost: Bytes, clearance: Floats32, radius: float) -> Costmap:
    # Nobody else holds these arrays, so sealing them saves the value its copies.
    cost.flags.writeable = False
    clearance.flags.writeable = False
    return Costmap(grid=grid, cost=cost, clearance=clearance, radius=radius)
