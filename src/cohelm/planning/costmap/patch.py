"""Nav2's cost values (nav2_costmap_2d/cost_values.hpp), and the window that a layer changes."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Bytes, Floats, Floats32, Shape, value
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid

FREE = 0
"""No obstacle near."""
MAX_GRADED = 252
"""Highest cost of a cell that the robot's centre may cross."""
INSCRIBED = 253
"""Closer to an obstacle than the inscribed radius; this value and all above block."""
LETHAL = 254
"""Obstacle."""
UNKNOWN = 255
"""Unobserved cell."""


@value
class Patch:
    """Costs in a window of the grid, combined by maximum with the costs below."""

    rows: slice
    cols: slice
    cost: Annotated[Bytes, Shape("rows cols")]
    """Nav2's cost values."""
    clearance: Annotated[Floats32, Shape("rows cols")] | None = None
    """Signed distance to the surface of what blocks, m, exact up to the inflation distance; None if
    the layer blocks nothing."""
    rule: bool = True
    """The patch blocks by a rule, not by an obstacle: a robot inside may leave."""
    extra_cost: Annotated[Floats32, Shape("rows cols")] | None = None
    """Minimum weight of the passable cells, for costs above Nav2's scale; 0: none."""


def window_around(
    points: Floats, reach: float, grid: OccupancyGrid
) -> tuple[Floats, slice, slice] | None:
    """Cells of ``grid`` that may lie within ``reach`` (m) of map points (k, 2).

    Returns:
        The points in the grid's frame, the rows and the columns; None if the window is empty.
    """
    local = transform(inverse(grid.X_MG), points)
    limit = np.array(grid.shape[::-1])
    low = np.floor((local.min(axis=0) - reach) / grid.resolution).clip(0, limit)
    high = np.ceil((local.max(axis=0) + reach) / grid.resolution).clip(0, limit)
    (c0, r0), (c1, r1) = low.astype(int).tolist(), high.astype(int).tolist()
    if math.prod((r1 - r0, c1 - c0)) == 0:
        return None
    return local, slice(r0, r1), slice(c0, c1)
