"""Static scene of 3-D sensors: floor, ceiling, and obstacles with their heights."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.kernels import CACHED, callee
from cohelm.maps import OccupancyGrid
from cohelm.simulation.sensors.floor_relief import LEVEL, FloorCells, FloorSurface


@value
class StaticScene:
    """Static obstacles. Create it once for each grid: derived values are cached."""

    grid: OccupancyGrid
    """Occupied cells are obstacles; unknown ones do not reflect."""
    heights: Annotated[Floats32, Shape("rows cols")] | None = None
    """Height of the obstacle on each cell over the floor, m; NaN: as high as the walls. Ignored on
    free cells. None: walls everywhere."""
    wall_height: float = 2.5
    """m."""
    ceiling: float = math.inf
    """Height of the ceiling over 0, m; +inf: none."""
    floor: FloorSurface = LEVEL
    cells: FloorCells | None = None
    """Floor with a relief, on the same grid, instead of ``floor``."""

    def floor_height(self, points: Floats) -> Floats:
        """Height (...,) of the floor at points (..., 2), m."""
        return self.floor.height(points) if self.cells is None else self.cells.height(points)

    def stance(self, X_MR: Floats) -> tuple[float, Floats]:
        """Height under a chair's axle, m, and the gradient (2,) of what it stands on, map frame."""
        if self.cells is not None:
            return self.cells.stance(X_MR)
        return float(self.floor.height(X_MR[:2])), self.floor.slope(X_MR[:2])

    @property
    def base(self) -> float:
        """Height from which rays count heights, m: that of the lowest cell of a relief, else 0."""
        return 0.0 if self.cells is None else self.cells.lowest


@lru_cache(maxsize=8)
def tops_of(scene: StaticScene) -> tuple[Floats32, float]:
    """Height (rows, cols) of what stands on a level floor, m, and its maximum over 0, m.

    With a relief the level floor lies at ``StaticScene.base``, and so do both heights.

    Raises:
        ValueError: if the heights do not have the shape of the grid.
    """
    grid, heights = scene.grid, scene.heights
    if heights is None:
        heights = np.full(grid.shape, np.nan, dtype=np.float32)
    if heights.shape != grid.shape:
        raise ValueError(f"heights of shape {heights.shape} on a grid of shape {grid.shape}")
    standing = np.where(np.isnan(heights), np.float32(scene.wall_height), heights)
    tops = np.where(grid.occupied(), standing, np.float32(0.0)).astype(np.float32)
    if scene.cells is not None:
        tops += scene.cells.heights - np.float32(scene.base)
    tops.flags.writeable = False
    return tops, float(tops.max(initial=0.0)) + scene.floor.highest


@njit(**CACHED, inline="always")
def floor_height(floor: Floats, x: float, y: float) -> float:
    """Height of a floor given by its numbers, m."""
    if floor[4] == 0.0:
        return 0.0
    run = (x - floor[0]) * floor[2] + (y - floor[1]) * floor[3]
    height: float = floor[4] * min(max(run, 0.0), floor[5])
    return height


@callee()
def to_floor(floor: Floats, origin: Floats, dx: float, dy: float, slope: float) -> float:
    """Horizontal distance at which a ray meets the floor, m; +inf: never.

    Args:
        floor: its numbers.
        origin: (3,) over the floor.
        dx, dy: horizontal unit direction.
        slope: rise over run of the ray.
    """
    # A level floor is one plane.
    best = np.inf
    if floor[4] == 0.0:
        return -origin[2] / slope if slope < 0.0 else best
    run = (origin[0] - floor[0]) * floor[2] + (origin[1] - floor[1]) * floor[3]
    gain = dx * floor[2] + dy * floor[3]
    # The level parts before and behind the ramp.
    if slope != 0.0:
        t = -origin[2] / slope
        if t >= 0.0 and run + t * gain <= 0.0:
            best = t
        t = (floor[4] * floor[5] - origin[2]) / slope
        if 0.0 <= t < best and run + t * gain >= floor[5]:
            best = t
    # The ramp itself.
    approach = slope - floor[4] * gain
    if approach != 0.0:
        t = (floor[4] * run - origin[2]) / approach
        if 0.0 <= t < best and 0.0 <= run + t * gain <= floor[5]:
            best = t
    return best
