"""What truly stands on a floor: the map, what it does not know, and doors that come and go."""

from __future__ import annotations

import math

import numpy as np

from cohelm.evaluation.things import Door, Obstacle
from cohelm.maps import OCCUPIED, OccupancyGrid
from cohelm.simulation import Change


def with_obstacles(grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]) -> OccupancyGrid:
    """The grid with things put on it: every cell whose centre one covers."""
    if not obstacles:
        return grid
    rows, cols = np.indices(grid.shape)
    centres = grid.centres(np.stack([rows, cols], axis=-1))
    data = grid.data.copy()
    for each in obstacles:
        delta = centres - np.array(each.at)
        if each.radius is not None:
            covered = np.hypot(delta[..., 0], delta[..., 1]) <= each.radius
        else:
            angle = math.radians(each.angle_deg)
            along = math.cos(angle) * delta[..., 0] + math.sin(angle) * delta[..., 1]
            aside = math.cos(angle) * delta[..., 1] - math.sin(angle) * delta[..., 0]
            half = np.array(each.size, dtype=float) / 2.0
            covered = (np.abs(along) <= half[0]) & (np.abs(aside) <= half[1])
        data[covered] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


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
