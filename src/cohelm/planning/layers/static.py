"""Static layer: the map itself."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Bytes
from cohelm.maps import OccupancyGrid
from cohelm.planning.cost_values import FREE, LETHAL, UNKNOWN


def static_costs(grid: OccupancyGrid) -> Bytes:
    """Costs (rows, cols): ``LETHAL`` where occupied, ``UNKNOWN`` where unknown, else ``FREE``."""
    cost = np.full(grid.shape, FREE, dtype=np.uint8)
    cost[grid.occupied()] = LETHAL
    cost[grid.data < 0] = UNKNOWN
    return cost
