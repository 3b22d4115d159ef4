"""Heights of a floor: a ramp across it, and pieces that lie higher or lower than the rest.

Planar worlds see them on a grid (:class:`FloorCells`), a world with wheels builds them as solids.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Shape, read_only, value
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid

_LENGTH, _WIDTH = 0.3, 0.22
"""Distances from the axle at which a chair rests on the floor, ahead and aside, m (assumed)."""


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
class FloorPiece:
    """Rectangle of floor at a height of its own: a bar, kerb, platform, pit, ramp or stairs.

    Along its first side the height goes from ``height`` to ``height + rise``, evenly or in steps,
    the last of which has the height of the end.
    """

    at: Annotated[Floats, Shape("2")]
    """Centre, m."""
    size: Annotated[Floats, Shape("2")]
    """Width and depth, m."""
    angle: float
    """Rotation, rad."""
    height: float
    """Over the floor, m; below 0 under it."""
    rise: float = 0.0
    """m."""
    steps: int = 0
    """Number of steps; 0: an even slope."""
    dark: bool = False
    """True: no sensor has a return of it."""

    def covers(self, points: Floats) -> Booleans:
        """Mask (...,) of points (..., 2) on it."""
        return np.asarray((np.abs(self._local(points)) <= self.size / 2.0).all(axis=-1))

    def heights(self, points: Floats) -> Floats:
        """Height (...,) over the floor at points (..., 2) on it, m."""
        share = np.clip(self._local(points)[..., 0] / self.size[0] + 0.5, 0.0, 1.0)
        if self.steps:
            share = np.minimum(np.floor(share * self.steps) + 1.0, self.steps) / self.steps
        return np.asarray(self.height + self.rise * share)

    @property
    def slabs(self) -> tuple[tuple[Floats, Floats, float, float], ...]:
        """(centre (2,), size (2,), heights of both ends) of parts without a step, m."""
        count = max(self.steps, 1)
        size = np.array([self.size[0] / count, self.size[1]])
        u = np.array([math.cos(self.angle), math.sin(self.angle)])
        out = []
        for k in range(count):
            centre = self.at + u * size[0] * (k + 0.5 - count / 2.0)
            end = self.height + self.rise * (k + 1) / count
            out.append((centre, size, end if self.steps else self.height, end))
        return tuple(out)

    def _local(self, points: Floats) -> Floats:
        away, c, s = points - self.at, math.cos(self.angle), math.sin(self.angle)
        return np.stack(
            [c * away[..., 0] + s * away[..., 1], c * away[..., 1] - s * away[..., 0]], axis=-1
        )


@value
class FloorRelief:
    """Heights of a floor that wheels drive over."""

    floor: FloorSurface = LEVEL
    pieces: tuple[FloorPiece, ...] = ()
    """A later one lies on an earlier one."""

    def heights(self, points: Floats) -> Floats:
        """Height (...,) at points (..., 2), m."""
        out = self.floor.height(points)
        for piece in self.pieces:
            on = piece.covers(points)
            out = np.where(on, self.floor.height(points) + piece.heights(points), out)
        return out


FLAT = FloorRelief()
"""Level floor at height 0."""


@value
class FloorCells:
    """A relief on the cells of a grid."""

    grid: OccupancyGrid
    heights: Annotated[Floats32, Shape("rows cols")]
    """m."""
    dark: Annotated[Booleans, Shape("rows cols")]
    """Cells of which no sensor has a return."""
    lowest: float
    """Minimum of the heights, m."""

    def height(self, points: Floats) -> Floats:
        """Height (...,) at points (..., 2), m; beyond the grid that of its nearest cell."""
        cells = np.clip(self.grid.cells(points), 0, np.array(self.grid.shape) - 1)
        return self.heights[cells[..., 0], cells[..., 1]].astype(float)

    def is_dark(self, points: Floats) -> Booleans:
        """Mask (...,) of points (..., 2) on dark floor."""
        cells = np.clip(self.grid.cells(points), 0, np.array(self.grid.shape) - 1)
        return np.asarray(self.dark[cells[..., 0], cells[..., 1]])

    def stance(self, X_MR: Floats) -> tuple[float, Floats]:
        """Height under a chair's axle, m, and the gradient (2,) of what it rests on, map frame."""
        supports = np.array([[_LENGTH, 0.0], [-_LENGTH, 0.0], [0.0, _WIDTH], [0.0, -_WIDTH]])
        ahead, behind, left, right = self.height(transform(X_MR, supports))
        along, aside = (ahead - behind) / (2.0 * _LENGTH), (left - right) / (2.0 * _WIDTH)
        c, s = math.cos(X_MR[2]), math.sin(X_MR[2])
        return float(left + right) / 2.0, np.array([c * along - s * aside, s * along + c * aside])


def floor_cells(relief: FloorRelief, grid: OccupancyGrid) -> FloorCells | None:
    """The relief on the cells of a grid; None: the floor is flat, and all of it is seen."""
    if relief.floor.gradient == 0.0 and not relief.pieces:
        return None
    rows, cols = np.meshgrid(*map(np.arange, grid.shape), indexing="ij")
    centres = grid.centres(np.stack([rows, cols], axis=-1))
    dark = np.zeros(grid.shape, dtype=np.bool_)
    for piece in relief.pieces:
        dark = np.where(piece.covers(centres), piece.dark, dark)
    heights = relief.heights(centres).astype(np.float32)
    return FloorCells(
        grid=grid, heights=read_only(heights), dark=read_only(dark), lowest=float(heights.min())
    )
