"""Exact gaps between the chair's footprint and people or walls, surface to surface."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import distance_to_polygon, transform
from cohelm.kernels import CACHED, callee
from cohelm.maps import OccupancyGrid
from cohelm.simulation.wall_geometry import SurfaceCells, near_cells, to_grid_frame, walls_of

_ROUNDING = 1e-9
"""m."""


def gap_to_people(outline: Floats, X_MR: Floats, position: Floats, radius: Floats) -> Floats:
    """Distance (n,) from the footprint to each person's disc, m; negative where they overlap.

    Args:
        outline: (k, 2) footprint in the robot's frame.
        X_MR: (3,).
        position: (n, 2) centres of the discs, map frame.
        radius: (n,) m.
    """
    return _to_discs(transform(X_MR, outline), position, radius)


def gap_to_walls(outline: Floats, X_MR: Floats, grid: OccupancyGrid) -> float:
    """Distance from the footprint to the nearest occupied cell, m; ≤ 0 where they overlap.

    +inf if no cell is occupied.
    """
    walls = walls_of(grid, unknown=False)
    polygon_G = _in_grid(transform(X_MR, outline), walls.cells)
    gap: float = _to_cells(polygon_G, walls.solid, walls.cells)
    return gap


@njit(**CACHED)
def _to_discs(polygon: Floats, position: Floats, radius: Floats) -> Floats:
    out = np.empty(position.shape[0])
    for i in range(position.shape[0]):
        out[i] = distance_to_polygon(polygon, position[i, 0], position[i, 1]) - radius[i]
    return out


@njit(**CACHED)
def _in_grid(points: Floats, cells: SurfaceCells) -> Floats:
    out = np.empty_like(points)
    for k in range(points.shape[0]):
        out[k, 0], out[k, 1] = to_grid_frame(cells, points[k, 0], points[k, 1])
    return out


@njit(**CACHED)
def _to_cells(polygon: Floats, solid: Booleans, cells: SurfaceCells) -> float:
    """Gap to the nearest cell; the search radius grows until it certainly contains that cell."""
    # A corner inside an occupied cell may be far from any surface cell.
    half = cells.half
    row, col = math.floor(polygon[0, 1] / (2.0 * half)), math.floor(polygon[0, 0] / (2.0 * half))
    if 0 <= row < solid.shape[0] and 0 <= col < solid.shape[1] and solid[row, col]:
        return 0.0
    x, y = polygon[:, 0].mean(), polygon[:, 1].mean()
    extent = 0.0
    for k in range(polygon.shape[0]):
        extent = max(extent, math.hypot(polygon[k, 0] - x, polygon[k, 1] - y))
    if cells.centre.shape[0] == 0:
        return np.inf
    radius = extent + 0.5
    while True:
        near = near_cells(cells, x, y, radius)
        gap = _nearest_cell(polygon, near, half, x, y, extent)
        if gap <= radius - extent or near.shape[0] == cells.centre.shape[0]:
            return gap
        radius *= 2.0


@callee()
def _nearest_cell(
    polygon: Floats, cells: Floats, half: float, x: float, y: float, extent: float
) -> float:
    """Minimum distance of a polygon within a disc (x, y, extent) to square cells; inf: no cells."""
    # Distances to centres first, from the cell whose centre is nearest to the disc.
    n = cells.shape[0]
    coarse = np.full(n, np.inf)
    first, square = 0, np.inf
    for k in range(n):
        dx, dy = cells[k, 0] - x, cells[k, 1] - y
        if dx * dx + dy * dy < square:
            first, square = k, dx * dx + dy * dy
    least = distance_to_polygon(polygon, cells[first, 0], cells[first, 1]) if n > 0 else np.inf
    for k in range(n):
        dx, dy = cells[k, 0] - x, cells[k, 1] - y
        reach = least + 3.0 * half + extent + _ROUNDING
        if dx * dx + dy * dy <= reach * reach:
            coarse[k] = distance_to_polygon(polygon, cells[k, 0], cells[k, 1])
            least = min(least, coarse[k])
    # Corners of a cell lie within √2 half of its centre, so only near centres matter.
    gap = np.inf
    for k in range(n):
        if coarse[k] <= least + 3.0 * half:
            gap = min(gap, _to_cell(polygon, cells[k, 0], cells[k, 1], half))
    return gap


@callee()
def _to_cell(polygon: Floats, cx: float, cy: float, half: float) -> float:
    """Distance from a polygon to one square cell; ≤ 0 where they overlap."""
    square = np.empty((4, 2))
    square[:, 0] = cx
    square[:, 1] = cy
    for k in range(4):
        square[k, 0] += half if k in (1, 2) else -half
        square[k, 1] += half if k in (2, 3) else -half
    gap = np.inf
    for k in range(4):
        gap = min(gap, distance_to_polygon(polygon, square[k, 0], square[k, 1]))
    n = polygon.shape[0]
    for k in range(n):
        gap = min(gap, distance_to_polygon(square, polygon[k, 0], polygon[k, 1]))
        if gap > 0.0 and _cuts_square(polygon[k], polygon[k - 1 if k > 0 else n - 1], cx, cy, half):
            return 0.0
    return gap


@callee()
def _cuts_square(a: Floats, b: Floats, cx: float, cy: float, half: float) -> bool:
    """Check that the segment from ``a`` to ``b`` enters a square (slab test)."""
    low, high = 0.0, 1.0
    for axis in range(2):
        at = a[axis] - (cx if axis == 0 else cy)
        slope = b[axis] - a[axis]
        if slope == 0.0:
            if abs(at) >= half:
                return False
            continue
        t0, t1 = (-half - at) / slope, (half - at) / slope
        low, high = max(low, min(t0, t1)), min(high, max(t0, t1))
    return low < high
