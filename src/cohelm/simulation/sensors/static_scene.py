"""Static scene of 3-D sensors: floor, ceiling, and obstacles with their heights."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.kernels import CACHED, callee
from cohelm.maps import OccupancyGrid


@value
class FloorSurface:
    """A level floor with one ramp in it: level at height 0, then rising, then level again.

    The height at p is gradient · clip((p − at) · u, 0, length), u being the direction; with an
    infinite length and ``at`` far behind, the whole floor is tilted.
    """

    at: Annotated[Floats, Shape("2")]
    """Beginning of the ramp, (x, y), m."""
    direction: float
    """Direction of the ramp, rad."""
    gradient: float
    """Rise over run; below 0 it falls, 0 is a level floor."""
    length: float = math.inf
    """Run, m."""

    def height(self, points: Floats) -> Floats:
        """Height (...,) of the floor at points (..., 2), m."""
        run = (points - self.at) @ np.array([math.cos(self.direction), math.sin(self.direction)])
        return np.asarray(self.gradient * np.clip(run, 0.0, self.length))

    def slope(self, point: Floats) -> Floats:
        """Gradient (∂h/∂x, ∂h/∂y) of the floor at a point (2,)."""
        u = np.array([math.cos(self.direction), math.sin(self.direction)])
        on_ramp = 0.0 <= float((point - self.at) @ u) <= self.length
        return self.gradient * u if on_ramp else np.zeros(2)

    @property
    def highest(self) -> float:
        """Maximum height, m."""
        return self.gradient * self.length if self.gradient > 0.0 else 0.0

    @property
    def numbers(self) -> Floats:
        """(x, y, u_x, u_y, gradient, length) for the kernels."""
        u_x, u_y = math.cos(self.direction), math.sin(self.direction)
        return np.array([*self.at, u_x, u_y, self.gradient, self.length])


LEVEL = FloorSurface(at=np.zeros(2), direction=0.0, gradient=0.0)
"""Height 0 everywhere."""


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


@lru_cache(maxsize=8)
def tops_of(scene: StaticScene) -> tuple[Floats32, float]:
    """Height (rows, cols) of the obstacles over the floor, m, and their maximum over 0, m.

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
