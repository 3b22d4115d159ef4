"""Static layers: the map and the keepout masks over it.

Keepout masks follow Nav2's KeepoutFilter. A mask value of 100 closes a cell, values between 0 and
100 cost in proportion, and an unknown cell has no effect. A closed cell counts as an obstacle: it
is inflated, as with an inflation layer among Nav2's filters. A robot inside a closed zone may leave
it, as with Nav2's ``override_lethal_cost``.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Bytes, Floats, SignedBytes
from cohelm.kernels import CACHED
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.maps.grid import OCCUPIED
from cohelm.maps.masks import CLOSED, project_mask
from cohelm.planning.costmap.patch import FREE, LETHAL, MAX_GRADED, UNKNOWN


@njit(**CACHED)
def raise_to_static(cost: Bytes, occupancy: SignedBytes) -> None:
    """Raise costs (rows, cols) in place to ``LETHAL`` where occupied and ``UNKNOWN`` where unknown.

    Args:
        cost: Nav2's cost values.
        occupancy: (rows, cols), −1 unknown, 0 free … 100 occupied.
    """
    for r in range(cost.shape[0]):
        for c in range(cost.shape[1]):
            known = LETHAL if occupancy[r, c] > OCCUPIED // 2 else 0
            cost[r, c] = UNKNOWN if occupancy[r, c] < 0 else max(cost[r, c], known)


def keepout_costs(filters: tuple[CostmapFilter, ...], grid: OccupancyGrid) -> Bytes:
    """Costs (rows, cols) of the masks of type ``keepout``; the maximum where masks overlap."""
    costs = np.full(grid.shape, FREE, dtype=np.uint8)
    for f in filters:
        if f.type == "keepout":
            project_mask(f, _costs_of_values, grid, costs)
    return costs


def _costs_of_values(values: Floats) -> Bytes:
    """Nav2's costs of mask values (n,): 2.54 times the value; only ``CLOSED`` blocks."""
    graded = np.clip(np.rint(values * (LETHAL / CLOSED)), FREE, MAX_GRADED)
    costs: Bytes = np.where(values >= CLOSED, LETHAL, graded).astype(np.uint8)
    return costs
