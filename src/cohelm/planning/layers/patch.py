"""What a layer says: costs in a window of the grid."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Bytes, Floats, Floats32, Shape, value
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid


@value
class Patch:
    """Costs in a window, to be combined by maximum with those that are there."""

    rows: slice
    cols: slice
    cost: Annotated[Bytes, Shape("rows cols")]
    """Nav2's values."""
    clearance: Annotated[Floats32, Shape("rows cols")] | None = None
    """Signed distance to the surface of what blocks, m, exact as far as it inflates; None where the
    layer blocks nothing."""
    rule: bool = True
    """Whether it blocks by a rule only, so that a robot that is inside may leave."""
    toll: Annotated[Floats32, Shape("rows cols")] | None = None
    """Least weight of the cells that can be passed at all, where costs cannot say how dear; 0:
    none."""


def window_about(
    points: Floats, reach: float, grid: OccupancyGrid
) -> tuple[Floats, slice, slice] | None:
    """The cells of ``grid`` that may lie within ``reach`` (m) of points (k, 2) of the map frame.

    Returns:
        The points in the grid's own frame, the rows and the columns; None where there are none.
    """
    local = transform(inverse(grid.X_MG), points)
    limit = np.array(grid.shape[::-1])
    low = np.floor((local.min(axis=0) - reach) / grid.resolution).clip(0, limit)
    high = np.ceil((local.max(axis=0) + reach) / grid.resolution).clip(0, limit)
    (c0, r0), (c1, r1) = low.astype(int).tolist(), high.astype(int).tolist()
    if math.prod((r1 - r0, c1 - c0)) == 0:
        return None
    return local, slice(r0, r1), slice(c0, c1)
