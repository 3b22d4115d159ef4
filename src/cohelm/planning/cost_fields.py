"""Cost-to-go of a map: distance that is left to drive from anywhere to each of several points.

The fields are functions of map, chair and points. They are computed once for a map, and sampled in
every tick.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.ndimage import distance_transform_edt

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Shape, value
from cohelm.kernels import CACHED
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.planning.costmap.costmap import build_costmap
from cohelm.planning.costmap.layers.inflation import Inflation
from cohelm.planning.costmap.patch import INSCRIBED
from cohelm.planning.grid_search.cost_field import cost_field
from cohelm.planning.grid_search.weights import BLOCKED, Weights

UNREACHABLE = 1e6
"""Cost where no path leads, m; every larger or interpolated value of this size means the same."""
_CELL = 0.1  # smallest side of a cell, m: a quarter of the time and memory of 0.05 m
_SNAP = 1.0  # largest distance of a point from a cell where the chair may stand, m


@value
class CostToGo:
    """Length of the shortest path from every cell to n points, for a chair of one width."""

    cost: Annotated[Floats32, Shape("rows cols n")]
    """m; blocked cells have the cost of the nearest free one and the way there."""
    free: Annotated[Booleans, Shape("rows cols")]
    """True where the inscribed circle of the chair fits."""
    resolution: float
    """m."""
    X_MG: Annotated[Floats, Shape("3")]
    """Pose of the lower left corner in the map frame."""

    def at(self, point: Floats) -> Floats:
        """Cost (n,) at a map point (2,), interpolated, m; ``UNREACHABLE`` or more without a way."""
        return _sample(self.cost, self.resolution, self.X_MG, float(point[0]), float(point[1]))

    def reached(self, point: Floats, direction: float, length: float) -> Floats:
        """Last free point (2,) along a straight line from a map point.

        Args:
            point: (2,), m.
            direction: in the map frame, rad.
            length: of the line, m.
        """
        return _march(self.free, self.resolution, self.X_MG, point, direction, length)


def cost_to_go(
    grid: OccupancyGrid,
    radius: float,
    points: Floats,
    filters: tuple[CostmapFilter, ...] = (),
) -> CostToGo:
    """Compute the cost-to-go to points (n, 2), m.

    A point without a free cell within a metre is unreachable from everywhere.

    Args:
        grid: map; unknown cells block.
        radius: of the circle that must fit, m.
        points: (n, 2), map frame, m.
        filters: masks over the map; keepout zones block.
    """
    costmap = build_costmap(grid, radius, Inflation(), filters=filters)
    free, scale = _coarse(costmap.cost < INSCRIBED, max(1, round(_CELL / grid.resolution)))
    resolution = grid.resolution * scale
    weights = Weights.of(np.where(free, np.float32(1.0), BLOCKED))
    out = np.full((*free.shape, len(points)), UNREACHABLE, dtype=np.float32)
    if free.any():
        away, nearest = distance_transform_edt(~free, return_indices=True)
        centres = grid.cells(points) // scale if len(points) else np.empty((0, 2), dtype=int)
        for k, cell in enumerate(centres.clip(0, np.array(free.shape) - 1)):
            if away[tuple(cell)] * resolution > _SNAP or not bool(grid.contains(points[k])):
                continue
            start = int(nearest[0][tuple(cell)]), int(nearest[1][tuple(cell)])
            field = cost_field(weights, start)[1:-1, 1:-1]
            far = (field[nearest[0], nearest[1]] + away) * resolution
            out[..., k] = np.where(np.isfinite(far), far, UNREACHABLE)
    for array in (out, free):
        array.flags.writeable = False  # no other owner: the value need not copy them
    return CostToGo(cost=out, free=free, resolution=resolution, X_MG=grid.X_MG)


def _coarse(free: Booleans, scale: int) -> tuple[Booleans, int]:
    """Join ``scale`` × ``scale`` cells into one that is free if one of them is.

    A narrow door stays open. No wall opens: the blocked band about it is wider than a cell.
    """
    rows, cols = (-(-side // scale) for side in free.shape)
    padded = np.zeros((rows * scale, cols * scale), dtype=np.bool_)
    padded[: free.shape[0], : free.shape[1]] = free
    return np.ascontiguousarray(padded.reshape(rows, scale, cols, scale).any(axis=(1, 3))), scale


@njit(**CACHED)
def _sample(cost: Floats32, resolution: float, X_MG: Floats, x: float, y: float) -> Floats:
    """Bilinear interpolation between cell centres; the nearest cell beyond the border."""
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    dx, dy = x - X_MG[0], y - X_MG[1]
    rows, cols, n = cost.shape
    c = min(max((cos * dx + sin * dy) / resolution - 0.5, 0.0), cols - 1.0)
    r = min(max((-sin * dx + cos * dy) / resolution - 0.5, 0.0), rows - 1.0)
    c0, r0 = min(int(c), max(cols - 2, 0)), min(int(r), max(rows - 2, 0))
    c1, r1 = min(c0 + 1, cols - 1), min(r0 + 1, rows - 1)
    u, v = c - c0, r - r0
    out = np.empty(n)
    for k in range(n):
        low = cost[r0, c0, k] * (1.0 - u) + cost[r0, c1, k] * u
        high = cost[r1, c0, k] * (1.0 - u) + cost[r1, c1, k] * u
        out[k] = low * (1.0 - v) + high * v
    return out


@njit(**CACHED)
def _march(
    free: Booleans,
    resolution: float,
    X_MG: Floats,
    point: Floats,
    direction: float,
    length: float,
) -> Floats:
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    rows, cols = free.shape
    last = np.array([point[0], point[1]])
    count = max(math.ceil(2.0 * length / resolution), 1)
    been_free = False
    for k in range(count + 1):
        x = point[0] + math.cos(direction) * length * k / count
        y = point[1] + math.sin(direction) * length * k / count
        dx, dy = x - X_MG[0], y - X_MG[1]
        c = math.floor((cos * dx + sin * dy) / resolution)
        r = math.floor((-sin * dx + cos * dy) / resolution)
        inside = 0 <= r < rows and 0 <= c < cols
        # A chair beside a wall may begin in a blocked cell; afterwards the first one ends the line.
        if inside and free[r, c]:
            been_free = True
            last[0], last[1] = x, y
        elif been_free or not inside:
            break
    return last
