"""What truly stands on a floor: the map, what it does not know, and doors that come and go."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cohelm.arrays import Booleans, Floats32
from cohelm.evaluation.things import Door, Obstacle
from cohelm.maps import OCCUPIED, OccupancyGrid
from cohelm.simulation import Change


def with_obstacles(grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]) -> OccupancyGrid:
    """The grid with things put on it: every cell whose centre one covers."""
    if not obstacles:
        return grid
    data = grid.data.copy()
    for _, covered in _covered(grid, obstacles):
        data[covered] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def with_heights(
    heights: Floats32 | None, grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]
) -> Floats32 | None:
    """Heights (rows, cols) of what stands on the grid's cells, m, NaN: as high as the walls.

    Args:
        heights: without the obstacles; None: walls everywhere, also returned where nothing is low.
        grid: whose cells.
        obstacles: that stand on it besides.
    """
    if heights is None and all(each.height is None for each in obstacles):
        return None
    out = np.full(grid.shape, np.nan, dtype=np.float32) if heights is None else heights.copy()
    for each, covered in _covered(grid, obstacles):
        out[covered] = np.nan if each.height is None else each.height
    return out


def changes(grid: OccupancyGrid, doors: tuple[Door, ...]) -> tuple[Change, ...]:
    """What stands there from time 0 on, and from each time on at which a door moves.

    With the same doors closed it is the same grid again.

    Args:
        grid: with every door open.
        doors: when each is closed.
    """
    times = sorted({0.0, *(t for door in doors for span in door.closed for t in span)})
    grids: dict[tuple[bool, ...], OccupancyGrid] = {}
    out = []
    for time in times:
        shut = tuple(door.is_closed(time) for door in doors)
        if shut not in grids:
            leaves = tuple(d.leaf for d, closed in zip(doors, shut, strict=True) if closed)
            grids[shut] = with_obstacles(grid, leaves)
        out.append(Change(time=time, grid=grids[shut]))
    return tuple(out)


def _covered(
    grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]
) -> Iterator[tuple[Obstacle, Booleans]]:
    """Each thing with the cells (rows, cols) whose centres it covers."""
    rows, cols = np.indices(grid.shape)
    centres = grid.centres(np.stack([rows, cols], axis=-1))
    for each in obstacles:
        delta = centres - np.array(each.at)
        if each.radius is not None:
            yield each, np.hypot(delta[..., 0], delta[..., 1]) <= each.radius
            continue
        angle = math.radians(each.angle_deg)
        along = math.cos(angle) * delta[..., 0] + math.sin(angle) * delta[..., 1]
        aside = math.cos(angle) * delta[..., 1] - math.sin(angle) * delta[..., 0]
        half = np.array(each.size, dtype=float) / 2.0
        yield each, (np.abs(along) <= half[0]) & (np.abs(aside) <= half[1])
