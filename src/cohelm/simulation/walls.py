"""What stands on a grid: its surface, and the convex piece of free floor about a person.

The nearest cell gives a half-plane that touches it and faces the person; every cell wholly behind
is done with; the nearest of the rest gives the next one. What remains in front of all half-planes
is free of cells, so a person who stays in it, by the body's radius, touches none (after the convex
free regions of Liu et al. 2017, IEEE RA-L 2(3), there about a segment of a path).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.maps import OccupancyGrid

_TILE = 1.0
"""Side of a bucket of surface cells, m."""
_FLUSH = 1e-7
"""How far a cell may stick out of a half-plane and still count as behind it, m."""


@value
class Walls:
    """What stands on a grid, its surface cells in square buckets; a pure function of the grid."""

    solid: Annotated[Booleans, Shape("rows cols")]
    """What stands there."""
    centre: Annotated[Floats, Shape("c 2")]
    """Of each surface cell, in the grid's frame, bucket after bucket, m."""
    start: Annotated[Integers, Shape("b")]
    """Where each bucket begins in ``centre``; one more than there are buckets, row by row."""
    tiles: Annotated[Integers, Shape("2")]
    """(rows, columns) of buckets."""
    half: float
    """Half a cell, m."""
    X_MG: Annotated[Floats, Shape("3")]


NO_WALLS = Walls(
    solid=np.zeros((1, 1), dtype=np.bool_),
    centre=np.empty((0, 2)),
    start=np.zeros(2, dtype=np.int64),
    tiles=np.ones(2, dtype=np.int64),
    half=0.5,
    X_MG=np.zeros(3),
)
"""An empty floor."""


@lru_cache(maxsize=8)
def walls_of(grid: OccupancyGrid, *, unknown: bool = True) -> Walls:
    """The surface of what stands on ``grid``; remembered for the grids used last.

    Args:
        grid: compared by identity, and it never changes.
        unknown: whether unknown cells stand in the way, too.
    """
    blocked = grid.blocked() if unknown else grid.occupied()
    cells = np.argwhere(blocked & ~_buried(blocked))
    per_tile = max(round(_TILE / grid.resolution), 1)
    rows, cols = (np.array(grid.shape) - 1) // per_tile + 1
    bucket = (cells[:, 0] // per_tile) * cols + cells[:, 1] // per_tile
    order = np.argsort(bucket, kind="stable")
    return Walls(
        solid=blocked,
        centre=np.asarray((cells[order][:, ::-1] + 0.5) * grid.resolution, dtype=np.float64),
        start=np.searchsorted(bucket[order], np.arange(rows * cols + 1)),
        tiles=np.array([rows, cols]),
        half=grid.resolution / 2.0,
        X_MG=grid.X_MG,
    )


def _buried(blocked: Booleans) -> Booleans:
    """Blocked cells whose four neighbours are blocked: no one can touch them."""
    padded = np.pad(blocked, 1, constant_values=True)
    buried: Booleans = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    return buried


@njit(cache=True)
def near_cells(  # noqa: PLR0917  # a kernel takes arrays and scalars
    centre: Floats, start: Integers, tiles: Integers, half: float, x: float, y: float, reach: float
) -> Floats:
    """Centres (k, 2) of the surface cells within ``reach`` of a point of the grid's frame."""
    per_tile = max(round(_TILE / (2.0 * half)), 1)
    side = per_tile * 2.0 * half
    r0 = max(math.floor((y - reach) / side), 0)
    r1 = min(math.floor((y + reach) / side), tiles[0] - 1)
    c0 = max(math.floor((x - reach) / side), 0)
    c1 = min(math.floor((x + reach) / side), tiles[1] - 1)
    if r1 < r0 or c1 < c0:
        return np.empty((0, 2))
    most = 0
    for r in range(r0, r1 + 1):
        most += start[r * tiles[1] + c1 + 1] - start[r * tiles[1] + c0]
    out = np.empty((most, 2))
    count = 0
    for r in range(r0, r1 + 1):
        for k in range(start[r * tiles[1] + c0], start[r * tiles[1] + c1 + 1]):
            dx = max(abs(centre[k, 0] - x) - half, 0.0)
            dy = max(abs(centre[k, 1] - y) - half, 0.0)
            if dx * dx + dy * dy <= reach * reach:
                out[count] = centre[k]
                count += 1
    return out[:count]


@njit(cache=True)
def free_region(cells: Floats, half: float, x: float, y: float) -> Floats:
    """Half-planes (k, 3) as (u_x, u_y, distance) whose common inside no cell enters.

    Args:
        cells: (c, 2) centres of square cells.
        half: half their side.
        x, y: the person, in the cells' frame.
    """
    n = cells.shape[0]
    near = np.empty((n, 3))
    for k in range(n):
        ox = min(max(x, cells[k, 0] - half), cells[k, 0] + half) - x
        oy = min(max(y, cells[k, 1] - half), cells[k, 1] + half) - y
        near[k, 0], near[k, 1], near[k, 2] = ox, oy, math.hypot(ox, oy)
    left = near[:, 2] > 0.0  # whoever stands inside a cell may leave it
    out = np.empty((n, 3))
    count = 0
    while True:
        best, distance = -1, np.inf
        for k in range(n):
            if left[k] and near[k, 2] < distance:
                best, distance = k, near[k, 2]
        if best < 0:
            return out[:count]
        ux, uy = near[best, 0] / distance, near[best, 1] / distance
        out[count, 0], out[count, 1], out[count, 2] = ux, uy, distance
        count += 1
        left[best] = False
        extent = half * (abs(ux) + abs(uy))
        for k in range(n):
            if left[k]:
                ahead = (cells[k, 0] - x) * ux + (cells[k, 1] - y) * uy - extent
                left[k] = ahead < distance - _FLUSH
