"""What a 3-D sensor can see of a building: a floor, walls and furniture as high as they are."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.maps import OccupancyGrid


@value
class Floor:
    """A level floor with one ramp in it: level at height 0, then rising, then level again.

    The height at p is gradient · clip((p − at) · u, 0, length), u being the direction; with an
    infinite length and ``at`` far behind, the whole floor is tilted.
    """

    at: Annotated[Floats, Shape("2")]
    """Where the ramp begins, (x, y), m."""
    direction: float
    """In which it rises, rad."""
    gradient: float
    """Rise over run; below 0 it falls, 0 is a level floor."""
    length: float = math.inf
    """Run, m."""

    def height(self, points: Floats) -> Floats:
        """Of the floor at points (..., 2), m; (...,)."""
        run = (points - self.at) @ np.array([math.cos(self.direction), math.sin(self.direction)])
        return np.asarray(self.gradient * np.clip(run, 0.0, self.length))

    def slope(self, point: Floats) -> Floats:
        """(∂h/∂x, ∂h/∂y) of the floor at a point (2,)."""
        u = np.array([math.cos(self.direction), math.sin(self.direction)])
        on_ramp = 0.0 <= float((point - self.at) @ u) <= self.length
        return self.gradient * u if on_ramp else np.zeros(2)

    @property
    def highest(self) -> float:
        """Of all its points, m."""
        return self.gradient * self.length if self.gradient > 0.0 else 0.0

    @property
    def numbers(self) -> Floats:
        """(x, y, u_x, u_y, gradient, length) for the kernels."""
        u_x, u_y = math.cos(self.direction), math.sin(self.direction)
        return np.array([*self.at, u_x, u_y, self.gradient, self.length])


LEVEL = Floor(at=np.zeros(2), direction=0.0, gradient=0.0)
"""Height 0 everywhere."""


@value
class Scenery:
    """Everything that stands still. Make it once for each grid: what is derived is remembered."""

    grid: OccupancyGrid
    """Its occupied cells stand in the way; unknown ones do not reflect."""
    heights: Annotated[Floats32, Shape("rows cols")] | None = None
    """Over the floor, m, of what stands on each cell of the grid; NaN: as high as the walls. Cells
    that are not occupied are empty whatever it says. None: walls everywhere."""
    wall_height: float = 2.5
    """m."""
    ceiling: float = math.inf
    """Height of the ceiling over 0, m; +inf: there is none."""
    floor: Floor = LEVEL


@lru_cache(maxsize=8)
def tops_of(scenery: Scenery) -> tuple[Floats32, float]:
    """Height (rows, cols) over the floor of what stands on each cell, 0 where nothing does, m.

    And a height over 0 above which nothing stands, m.

    Raises:
        ValueError: if the heights are not those of the grid.
    """
    grid, heights = scenery.grid, scenery.heights
    if heights is None:
        heights = np.full(grid.shape, np.nan, dtype=np.float32)
    if heights.shape != grid.shape:
        raise ValueError(f"heights of shape {heights.shape} on a grid of shape {grid.shape}")
    standing = np.where(np.isnan(heights), np.float32(scenery.wall_height), heights)
    tops = np.where(grid.occupied(), standing, np.float32(0.0)).astype(np.float32)
    tops.flags.writeable = False
    return tops, float(tops.max(initial=0.0)) + scenery.floor.highest


@njit(cache=True, inline="always")
def floor_height(floor: Floats, x: float, y: float) -> float:
    """Of a floor given by its numbers, m."""
    if floor[4] == 0.0:
        return 0.0
    run = (x - floor[0]) * floor[2] + (y - floor[1]) * floor[3]
    height: float = floor[4] * min(max(run, 0.0), floor[5])
    return height


@njit(cache=True)
def to_floor(floor: Floats, origin: Floats, dx: float, dy: float, slope: float) -> float:
    """How far a ray goes on the level until it meets the floor, m; +inf if never.

    Args:
        floor: its numbers.
        origin: (3,) over the floor.
        dx, dy: unit direction on the level.
        slope: rise over run of the ray.
    """
    best = np.inf
    if floor[4] == 0.0:
        return -origin[2] / slope if slope < 0.0 else best
    run = (origin[0] - floor[0]) * floor[2] + (origin[1] - floor[1]) * floor[3]
    gain = dx * floor[2] + dy * floor[3]
    if slope != 0.0:
        t = -origin[2] / slope
        if t >= 0.0 and run + t * gain <= 0.0:
            best = t
        t = (floor[4] * floor[5] - origin[2]) / slope
        if 0.0 <= t < best and run + t * gain >= floor[5]:
            best = t
    approach = slope - floor[4] * gain
    if approach != 0.0:
        t = (floor[4] * run - origin[2]) / approach
        if 0.0 <= t < best and 0.0 <= run + t * gain <= floor[5]:
            best = t
    return best
