"""Drawing of floors: walls, free floor, openings and blocks in the cells of a grid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, SignedBytes
from cohelm.geometry import distance_to_polygon
from cohelm.kernels import CACHED
from cohelm.maps.distance import signed_distance
from cohelm.maps.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid


class Canvas:
    """Cells of a floor while it is drawn; the map's frame has its origin at the lower left.

    A cell belongs to a shape if its centre does.

    Args:
        size: width and height, m.
        resolution: side of a cell, m.
        outside: initial value of the cells.
    """

    def __init__(
        self,
        *,
        size: tuple[float, float],
        resolution: float,
        outside: Literal["unknown", "occupied"],
    ) -> None:
        cols, rows = (max(1, round(side / resolution)) for side in size)
        self._resolution = resolution
        first = UNKNOWN if outside == "unknown" else OCCUPIED
        self._cells: SignedBytes = np.full((rows, cols), first, dtype=np.int8)
        self._heights: Floats32 = np.full((rows, cols), np.nan, dtype=np.float32)

    def wall(self, corners: Floats, thickness: float) -> None:
        """Draw a wall whose centre line is a polygon (k, 2)."""
        half = thickness / 2.0
        self._paint(corners, -half, half, OCCUPIED)

    def floor(self, corners: Floats, thickness: float) -> None:
        """Draw free floor inside the walls of a polygon (k, 2)."""
        self._paint(corners, -np.inf, -thickness / 2.0, FREE)

    def block(self, corners: Floats) -> None:
        """Draw an object on the floor, a polygon (k, 2)."""
        self._paint(corners, -np.inf, 0.0, OCCUPIED)

    def rise(self, corners: Floats, height: float) -> None:
        """Set the height of the objects in a polygon (k, 2), m; NaN: as high as the walls."""
        window, distance = self._around(corners, reach=0.0)
        self._heights[window][distance < 0.0] = height

    def opening(self, at: Floats, a: Floats, b: Floats, width: float, thickness: float) -> None:
        """Cut a passage of ``width`` through the wall from a to b (2,), beside ``at`` (2,).

        The cut extends a cell beyond the wall's faces, so that none of it is left.
        """
        along = (b - a) / np.hypot(*(b - a))
        middle = a + along * np.dot(at - a, along)
        across = np.array([-along[1], along[0]]) * (thickness / 2.0 + self._resolution)
        side = along * width / 2.0
        corners = np.array(
            [middle - side - across, middle + side - across, middle + side + across,
             middle - side + across]
        )  # fmt: skip
        self._paint(corners, -np.inf, 0.0, FREE)

    def clearance(self) -> Floats32:
        """Signed distance (rows, cols) of the cells to what is not free, m."""
        return signed_distance(self._cells != FREE, self._resolution)

    def roomiest(self, corners: Floats, clearance: Floats32) -> tuple[Floats, float]:
        """Cell centre (2,) in a polygon (k, 2) with the most free space, and that space, m.

        The space is the clearance or the distance to the polygon's edge, whichever is less. Of
        cells with equal space to within a cell, the most central one is taken.
        """
        window, distance = self._around(corners, reach=0.0)
        room = np.minimum(clearance[window], -distance)
        rows, cols = np.nonzero(room >= room.max() - self._resolution)
        cells = np.stack([cols + window[1].start, rows + window[0].start], axis=-1)
        points = (cells + 0.5) * self._resolution
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
        best = int(np.argmin(np.hypot(*(points - middle).T)))
        return points[best].astype(np.float64), float(room[rows[best], cols[best]])

    def grid(self) -> OccupancyGrid:
        """Grid of the drawn cells."""
        return OccupancyGrid(data=self._cells.copy(), resolution=self._resolution, X_MG=np.zeros(3))

    def heights(self) -> Floats32:
        """Heights of the cells (rows, cols), m; NaN where none was set."""
        return self._heights.copy()

    def _paint(self, corners: Floats, low: float, high: float, cell: int) -> None:
        """Set the cells with a signed distance in [low, high) to a polygon (k, 2)."""
        window, distance = self._around(corners, reach=high)
        self._cells[window][(low <= distance) & (distance < high)] = cell

    def _around(self, corners: Floats, *, reach: float) -> tuple[tuple[slice, slice], Floats]:
        """Cells up to ``reach`` from a polygon (k, 2), and their signed distances to it."""
        low = np.floor((corners.min(axis=0) - reach) / self._resolution).astype(int)
        high = np.ceil((corners.max(axis=0) + reach) / self._resolution).astype(int)
        c0, r0 = np.maximum(low, 0)
        c1, r1 = np.minimum(high, self._cells.shape[::-1])
        distance = _signed_distances(corners, self._resolution, r0, r1, c0, c1)
        return (slice(r0, r1), slice(c0, c1)), distance


def polygon_of_rect(rect: Sequence[float]) -> Floats:
    """Corners (4, 2), anticlockwise, of [x0, y0, x1, y1]."""
    x0, y0, x1, y1 = rect
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


def polygon_of_disc(disc: Sequence[float]) -> Floats:
    """Corners (32, 2), anticlockwise, on the rim of [x, y, radius]."""
    x, y, radius = disc
    angle = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    return np.array([x, y]) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def rotate(corners: Floats, angle: float) -> Floats:
    """Polygon (k, 2) rotated anticlockwise by ``angle`` about the centre of its bounding box."""
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    cos, sin = np.cos(angle), np.sin(angle)
    rotation = np.array([[cos, -sin], [sin, cos]])
    result: Floats = middle + (corners - middle) @ rotation.T
    return result


@njit(**CACHED)
def _signed_distances(
    corners: Floats, resolution: float, r0: int, r1: int, c0: int, c1: int
) -> Floats:
    """Signed distance (r1 − r0, c1 − c0) of cell centres to a polygon (k, 2), m."""
    out = np.empty((max(r1 - r0, 0), max(c1 - c0, 0)))
    for r in range(r0, r1):
        for c in range(c0, c1):
            x, y = (c + 0.5) * resolution, (r + 0.5) * resolution
            out[r - r0, c - c0] = distance_to_polygon(corners, x, y)
    return out
