"""Walkable space of a map, and shortest paths in it, on a coarse grid."""

from __future__ import annotations

import heapq
import math

import cv2
import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, value
from cohelm.errors import ScenarioError
from cohelm.geometry import resample
from cohelm.kernels import CACHED
from cohelm.maps import OccupancyGrid, distance_field, signed_distance

CELL = 0.15
"""Cell size of the coarse grid, m."""
MARGIN = 0.10
"""Distance of a route from walls beyond the body's radius, m."""
PASSABLE = 1.05
"""Half the width of a corridor in which a chair and a person can pass each other, m."""
LARGEST = 1e6
"""Largest area of a map on which routes are drawn, m²: 44 million coarse cells."""


@value
class Walkable:
    """Coarse grid of the walkable space, with its narrow parts near one route."""

    free: Annotated[Booleans, Shape("rows cols")]
    narrow: Annotated[Booleans, Shape("rows cols")]
    """Cells near the route where a chair and a person cannot pass each other."""
    clearance: Annotated[Floats32, Shape("rows cols")]
    """Distance to the nearest wall, m."""
    origin: Annotated[Floats, Shape("2")]
    """Centre of cell (0, 0), m; rows run along y, columns along x of the map frame."""

    def cell(self, point: Floats) -> tuple[int, int]:
        """(row, column) of a map point, clipped to the grid."""
        row, col = _cells(np.asarray(point), self.origin, self.free.shape)
        return int(row), int(col)

    def points(self, cells: Integers) -> Floats:
        """Centres (m, 2) of cells (m, 2) given as (row, column)."""
        return self.origin + CELL * np.asarray(cells)[:, ::-1]


def walkable(grid: OccupancyGrid, radius: float, route: Floats) -> Walkable:
    """Cells whose distance to the walls exceeds a body's radius and the margin.

    Args:
        grid: true occupancy.
        radius: radius of a body, m.
        route: route of the robot (k, 2), m.

    Raises:
        ScenarioError: if the map is larger than :data:`LARGEST`.
    """
    x0, y0, x1, y1 = grid.bounds
    if (x1 - x0) * (y1 - y0) > LARGEST:
        raise ScenarioError(
            f"the map of {x1 - x0:.0f} x {y1 - y0:.0f} m is too large to draw pedestrian routes "
            "on; check its resolution, or set people.count=0",
            key="map",
        )
    x, y = np.meshgrid(np.arange(x0 + CELL / 2, x1, CELL), np.arange(y0 + CELL / 2, y1, CELL))
    points = np.stack([x, y], axis=-1)
    clearance = np.where(grid.contains(points), distance_field(grid).at(points), -1.0)
    origin = np.array([x0 + CELL / 2, y0 + CELL / 2])
    clearance = clearance.astype(np.float32)
    return Walkable(
        free=clearance > radius + MARGIN,
        narrow=_narrow(clearance, _cells(resample(route, CELL), origin, clearance.shape)),
        clearance=clearance,
        origin=origin,
    )


def connected_cells(floor: Walkable, point: Floats) -> Integers:
    """Free cells (m, 2) that a person can reach from the free cell nearest to a point, row-major.

    Empty where no cell is free.
    """
    free = np.argwhere(floor.free)
    if not len(free):
        return free
    nearest = free[int(np.argmin(((floor.points(free) - point) ** 2).sum(axis=1)))]
    # 4-connected, because a diagonal step must not cut a corner.
    _, label = cv2.connectedComponents(floor.free.astype(np.uint8), connectivity=4)
    cells: Integers = np.argwhere(label == label[tuple(nearest)])
    return cells


@njit(**CACHED)
def spread(
    free: Booleans, narrow: Booleans, row: int, col: int, limit: float
) -> tuple[Floats, Floats, Integers]:
    """Run Dijkstra's algorithm from a cell over free cells, 8-connected.

    The first cell counts as free. Diagonal steps do not cut the corners of walls.

    Args:
        free: (rows, cols) free cells.
        narrow: (rows, cols) narrow cells.
        row, col: first cell.
        limit: largest distance, in cells.

    Returns:
        (distance, length of its narrow part, both in cells; index of the parent cell or −1).
    """
    rows, cols = free.shape
    distance = np.full((rows, cols), np.inf)
    shared = np.zeros((rows, cols))
    parent = np.full((rows, cols), -1, dtype=np.int64)
    distance[row, col] = 0.0
    queue = [(0.0, row, col)]
    while len(queue) > 0:
        d, r, c = heapq.heappop(queue)
        if d > distance[r, c] or d > limit:
            continue
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                i, j = r + dr, c + dc
                if i < 0 or j < 0 or i >= rows or j >= cols or not free[i, j]:
                    continue
                if dr != 0 and dc != 0 and not (free[i, c] and free[r, j]):
                    continue
                step = math.sqrt(dr * dr + dc * dc)
                through = d + step
                if through < distance[i, j]:
                    distance[i, j] = through
                    shared[i, j] = shared[r, c] + (step if narrow[i, j] else 0.0)
                    parent[i, j] = r * cols + c
                    heapq.heappush(queue, (through, i, j))
    return distance, shared, parent


def trace(parent: Integers, row: int, col: int) -> Integers:
    """Cells (m, 2) from a cell back to the start of :func:`spread`."""
    cols = parent.shape[1]
    cells = [(row, col)]
    while parent[row, col] >= 0:
        row, col = divmod(int(parent[row, col]), cols)
        cells.append((row, col))
    return np.array(cells, dtype=np.int64)


def pulled_tight(free: Booleans, cells: Integers) -> Integers:
    """String pulling: the cells (m, 2) of a path at which it must bend."""
    corners, at = [0], 0
    while at < len(cells) - 1:
        far = at + 1
        while far < len(cells) - 1 and _sees(free, cells[at], cells[far + 1]):
            far += 1
        corners.append(far)
        at = far
    return cells[corners]


@njit(**CACHED)
def _sees(free: Booleans, a: Integers, b: Integers) -> bool:
    """Check that all cells on the segment between two cells are free."""
    steps = 2 * max(abs(b[0] - a[0]), abs(b[1] - a[1]), 1)
    for i in range(steps + 1):
        r = round(a[0] + (b[0] - a[0]) * i / steps)
        c = round(a[1] + (b[1] - a[1]) * i / steps)
        if not free[r, c]:
            return False
    return True


def _narrow(clearance: Floats32, route: Integers) -> Booleans:
    """Cells (rows, cols) within 1.2 m of the narrow cells of a route (k, 2).

    A cell of the route is narrow if no cell within 0.75 m has the clearance of the centre line of a
    passable corridor.
    """
    size = 2 * round(0.75 / CELL) + 1
    widest = cv2.dilate(clearance, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)))
    tight = np.zeros(clearance.shape, dtype=bool)
    row, col = route.T
    tight[row, col] = widest[row, col] < PASSABLE
    near: Booleans = signed_distance(tight, CELL) < 1.2
    return near


def _cells(points: Floats, origin: Floats, shape: tuple[int, ...]) -> Integers:
    cells = np.rint((points - origin) / CELL).astype(np.int64)[..., ::-1]
    return np.clip(cells, 0, np.array(shape) - 1)
