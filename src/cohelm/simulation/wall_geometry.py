"""Wall geometry of a grid: surface cells, and the convex free region about a person.

The nearest cell gives a half-plane that touches it and faces the person; every cell that lies
wholly behind it is done; the nearest of the rest gives the next half-plane. The region in front of
all half-planes is free of cells, so a person who stays in it by the body's radius touches none
(after the convex free regions of Liu et al. 2017, IEEE RA-L 2(3), there about a path segment).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, read_only, value
from cohelm.kernels import CACHED, callee
from cohelm.maps import OccupancyGrid

_TILE = 1.0
"""Side of a bucket of surface cells, m."""
_FLUSH = 1e-7
"""Maximum distance by which a cell behind a half-plane may protrude, m."""


class SurfaceCells(NamedTuple):
    """Surface cells of a grid in square buckets, for kernels."""

    centre: Floats
    """(c, 2) in the grid's frame, bucket after bucket, m."""
    start: Integers
    """(b + 1,) index of each bucket's first cell in ``centre``, row by row."""
    tiles: Integers
    """(rows, columns) of buckets."""
    half: float
    """Half the side of a cell, m."""
    X_MG: Floats
    """(3,) the grid in the map frame."""


@value
class GridWalls:
    """Occupied cells of a grid; a pure function of the grid."""

    solid: Annotated[Booleans, Shape("rows cols")]
    """True where occupied."""
    cells: SurfaceCells


NO_WALLS = GridWalls(
    solid=np.zeros((1, 1), dtype=np.bool_),
    cells=SurfaceCells(
        centre=read_only(np.empty((0, 2))),
        start=read_only(np.zeros(2, dtype=np.int64)),
        tiles=read_only(np.ones(2, dtype=np.int64)),
        half=0.5,
        X_MG=read_only(np.zeros(3)),
    ),
)
"""An empty floor."""


@lru_cache(maxsize=8)
def walls_of(grid: OccupancyGrid, *, unknown: bool = True) -> GridWalls:
    """Find the surface cells of ``grid``; cached for the last grids.

    Args:
        grid: compared by identity, and it never changes.
        unknown: True if unknown cells count as occupied.
    """
    blocked = grid.blocked() if unknown else grid.occupied()
    cells = np.argwhere(blocked & ~_buried(blocked))
    per_tile = max(round(_TILE / grid.resolution), 1)
    rows, cols = (np.array(grid.shape) - 1) // per_tile + 1
    bucket = (cells[:, 0] // per_tile) * cols + cells[:, 1] // per_tile
    order = np.argsort(bucket, kind="stable")
    centre = np.ascontiguousarray((cells[order][:, ::-1] + 0.5) * grid.resolution)
    start = np.searchsorted(bucket[order], np.arange(rows * cols + 1))
    return GridWalls(
        solid=blocked,
        cells=SurfaceCells(
            centre=read_only(centre),
            start=read_only(start),
            tiles=read_only(np.array([rows, cols])),
            half=grid.resolution / 2.0,
            X_MG=grid.X_MG,
        ),
    )


def _buried(blocked: Booleans) -> Booleans:
    """Mask of blocked cells whose four neighbours are blocked, which nothing can touch."""
    padded = np.pad(blocked, 1, constant_values=True)
    buried: Booleans = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    return buried


@callee()
def near_cells(cells: SurfaceCells, x: float, y: float, distance: float) -> Floats:
    """Centres (k, 2) of the surface cells within a distance of a point of the grid's frame."""
    # Range of the buckets that the square about the point covers.
    half = cells.half
    per_tile = max(round(_TILE / (2.0 * half)), 1)
    side = per_tile * 2.0 * half
    r0 = max(math.floor((y - distance) / side), 0)
    r1 = min(math.floor((y + distance) / side), cells.tiles[0] - 1)
    c0 = max(math.floor((x - distance) / side), 0)
    c1 = min(math.floor((x + distance) / side), cells.tiles[1] - 1)
    if r1 < r0 or c1 < c0:
        return np.empty((0, 2))
    # Buckets of one row are contiguous, so their size is a difference.
    start, columns = cells.start, cells.tiles[1]
    size = 0
    for r in range(r0, r1 + 1):
        size += start[r * columns + c1 + 1] - start[r * columns + c0]
    out = np.empty((size, 2))
    count = 0
    for r in range(r0, r1 + 1):
        for k in range(start[r * columns + c0], start[r * columns + c1 + 1]):
            dx = max(abs(cells.centre[k, 0] - x) - half, 0.0)
            dy = max(abs(cells.centre[k, 1] - y) - half, 0.0)
            if dx * dx + dy * dy <= distance * distance:
                out[count, 0], out[count, 1] = cells.centre[k, 0], cells.centre[k, 1]
                count += 1
    return out[:count]


@callee()
def to_grid_frame(cells: SurfaceCells, x: float, y: float) -> tuple[float, float]:
    """Transform a point of the map frame to the grid's frame."""
    cos, sin = math.cos(cells.X_MG[2]), math.sin(cells.X_MG[2])
    ox, oy = x - cells.X_MG[0], y - cells.X_MG[1]
    return cos * ox + sin * oy, -sin * ox + cos * oy


@njit(**CACHED)
def free_region(cells: Floats, half: float, x: float, y: float) -> Floats:
    """Half-planes (k, 3) as (u_x, u_y, distance) whose intersection no cell enters.

    Args:
        cells: (c, 2) centres of square cells.
        half: half their side.
        x, y: the person, in the cells' frame.
    """
    # Offset and distance of the nearest point of each cell.
    n = cells.shape[0]
    near = np.empty((n, 3))
    for k in range(n):
        ox = min(max(x, cells[k, 0] - half), cells[k, 0] + half) - x
        oy = min(max(y, cells[k, 1] - half), cells[k, 1] + half) - y
        near[k, 0], near[k, 1], near[k, 2] = ox, oy, math.hypot(ox, oy)
    # A person inside a cell may leave it.
    left = near[:, 2] > 0.0
    out = np.empty((n, 3))
    count = 0
    while True:
        # The nearest remaining cell gives the next half-plane.
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
        # Cells wholly behind it are done.
        extent = half * (abs(ux) + abs(uy))
        for k in range(n):
            if left[k]:
                ahead = (cells[k, 0] - x) * ux + (cells[k, 1] - y) * uy - extent
                left[k] = ahead < distance - _FLUSH
