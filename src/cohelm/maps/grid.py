"""Occupancy grid of a floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, SignedBytes, value
from cohelm.geometry import inverse, transform

UNKNOWN = -1
FREE = 0
OCCUPIED = 100

MAX_COORDINATE = 1e7
"""Largest coordinate, m: covers national grids, and is far below overflow."""


@value
class OccupancyGrid:
    """Occupancy as in nav_msgs/OccupancyGrid: −1 unknown, 0 free … 100 occupied.

    Cell (row, column) = (0, 0) is the lower left one; its outer corner is the grid's origin. Rows
    run along the grid's y axis, columns along its x axis.
    """

    data: Annotated[SignedBytes, Shape("rows cols")]
    resolution: float
    """Side of a cell, m."""
    X_MG: Annotated[Floats, Shape("3")]
    """Pose of the grid's lower left corner in the map frame (``origin`` of a map YAML)."""

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        rows, cols = self.data.shape
        return rows, cols

    @property
    def size(self) -> tuple[float, float]:
        """(width along x, height along y) in the grid's frame, m."""
        rows, cols = self.data.shape
        return cols * self.resolution, rows * self.resolution

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, y_min, x_max, y_max) in the map frame, m."""
        w, h = self.size
        corners = transform(self.X_MG, np.array([[0, 0], [w, 0], [w, h], [0, h]]))
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        return float(x0), float(y0), float(x1), float(y1)

    def blocked(self) -> Booleans:
        """Blocked cells (rows, cols): occupied above half, or unknown."""
        return (self.data < 0) | (self.data > OCCUPIED // 2)

    def occupied(self) -> Booleans:
        """Cells known to be occupied above half; (rows, cols)."""
        return self.data > OCCUPIED // 2

    def cells(self, points: ArrayLike) -> Integers:
        """(row, column) of points (..., 2) in the map frame; may lie outside the grid."""
        p = transform(inverse(self.X_MG), points) / self.resolution
        return np.floor(p[..., ::-1]).astype(np.int64)

    def centres(self, cells: ArrayLike) -> Floats:
        """Map points (..., 2) at the centres of cells (..., 2) given as (row, column)."""
        c = np.asarray(cells, dtype=float)[..., ::-1]
        return transform(self.X_MG, (c + 0.5) * self.resolution)

    def contains(self, points: ArrayLike) -> Booleans:
        """True (...,) for the points (..., 2) of the map frame that lie on the grid."""
        cells = self.cells(points)
        inside: Booleans = np.all((cells >= 0) & (cells < np.array(self.shape)), axis=-1)
        return inside
