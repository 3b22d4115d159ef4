"""Knowledge that is split between rider and chair: what only one of them sees, a change of mind."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.maps import FREE, OCCUPIED, OccupancyGrid


@value
class GoalChange:
    """A new destination that the rider decides for on the way."""

    near: Annotated[Floats, Shape("2")]
    """Place at which the rider decides, m."""
    within: float
    """Distance from it at which the rider decides, m."""
    goal: Annotated[Floats, Shape("2")]
    """New destination, m."""
    route: Annotated[Floats, Shape("k 2")]
    """Desired route from the place to the new destination, m."""

    def is_due(self, position: Floats) -> bool:
        """Check that a chair at ``position`` (2,) is near the place."""
        x, y = position - self.near
        return math.hypot(x, y) <= self.within


@value
class SplitCells:
    """Cells of a world that rider and chair see differently; each (rows, cols)."""

    unsensed: Annotated[Booleans, Shape("rows cols")]
    """Obstacles that no sensor of the chair detects, as glass; the rider sees them."""
    avoided: Annotated[Booleans, Shape("rows cols")]
    """Free floor that the rider avoids, as a wet one, and the chair does not know."""


@value
class GridViews:
    """One world as it is, as the chair's sensors detect it, and as the rider keeps clear of it."""

    truth: OccupancyGrid
    sensed: OccupancyGrid
    rider: OccupancyGrid


@lru_cache(maxsize=16)
def grid_views(grid: OccupancyGrid, split: SplitCells | None) -> GridViews:
    """Views of true obstacles; equal arguments return the same objects, so that caches hold.

    Args:
        grid: true obstacles; compared by identity.
        split: None: chair and rider see all.
    """
    if split is None:
        return GridViews(truth=grid, sensed=grid, rider=grid)
    return GridViews(
        truth=grid,
        sensed=with_cells(grid, split.unsensed, FREE),
        rider=with_cells(grid, split.avoided, OCCUPIED),
    )


def with_cells(grid: OccupancyGrid, cells: Booleans, content: int) -> OccupancyGrid:
    """Grid with some cells (rows, cols) set; the same object where none is."""
    if not cells.any():
        return grid
    data = np.where(cells, np.int8(content), grid.data)
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)
