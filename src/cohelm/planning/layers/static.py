"""Static layer: the map itself."""

from __future__ import annotations

from numba import njit

from cohelm.arrays import Bytes, SignedBytes
from cohelm.maps.grid import OCCUPIED
from cohelm.planning.cost_values import LETHAL, UNKNOWN


@njit(cache=True)
def raise_to_static(cost: Bytes, occupancy: SignedBytes) -> None:
    """Raise costs (rows, cols) in place to ``LETHAL`` where occupied and ``UNKNOWN`` where unknown.

    Args:
        cost: Nav2's values.
        occupancy: (rows, cols), −1 unknown, 0 free … 100 occupied.
    """
    for r in range(cost.shape[0]):
        for c in range(cost.shape[1]):
            known = LETHAL if occupancy[r, c] > OCCUPIED // 2 else 0
            cost[r, c] = UNKNOWN if occupancy[r, c] < 0 else max(cost[r, c], known)
