"""Local distance field about the robot: the map's field with openings, and the live obstacles."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cohelm.arrays import Floats, Floats32
from cohelm.geometry import transform
from cohelm.maps import DistanceField, OccupancyGrid, signed_distance
from cohelm.messages import LiveObstacles
from cohelm.navigation.map_openings import FreeCells, with_openings


def local_walls(
    grid: OccupancyGrid,
    static: DistanceField,
    live: LiveObstacles,
    free: FreeCells,
    position: Floats,
    extent: float,
) -> DistanceField:
    """Compute the distance field of a window about the robot.

    Args:
        grid: the map.
        static: its distance field.
        live: obstacles that are not in the map.
        free: walls of the map that are not there.
        position: (2,), m.
        extent: half the side of the window, m.
    """
    row, col = grid.cells(position)
    half = int(np.ceil(extent / grid.resolution))
    r0, c0 = max(int(row) - half, 0), max(int(col) - half, 0)
    r1, c1 = min(int(row) + half, grid.shape[0]), min(int(col) + half, grid.shape[1])
    r1, c1 = max(r1, r0 + 1), max(c1, c0 + 1)
    r0, c0 = min(r0, grid.shape[0] - 1), min(c0, grid.shape[1] - 1)
    corner = np.array([r0, c0])
    window = with_openings(static.distance[r0:r1, c0:c1], corner, static, free)
    live_distance = _live_distances(live, grid.resolution)
    if live_distance is None:
        # Contiguous as with obstacles; otherwise kernels are compiled for both layouts.
        distance = np.ascontiguousarray(window)
    else:
        distance = window.copy()
        lr, lc = int(live.corner[0]), int(live.corner[1])
        rows, cols = live_distance.shape
        a0, b0 = max(r0, lr), max(c0, lc)
        a1, b1 = min(r1, lr + rows), min(c1, lc + cols)
        if a1 > a0 and b1 > b0:
            ours = distance[a0 - r0 : a1 - r0, b0 - c0 : b1 - c0]
            np.minimum(ours, live_distance[a0 - lr : a1 - lr, b0 - lc : b1 - lc], out=ours)
    # A read-only array is not copied by the value.
    distance.flags.writeable = False
    X_MW = grid.X_MG.copy()
    X_MW[:2] = transform(grid.X_MG, np.array([c0, r0]) * grid.resolution)
    return DistanceField(distance=distance, resolution=grid.resolution, X_MG=X_MW)


@lru_cache(maxsize=4)
def _live_distances(live: LiveObstacles, resolution: float) -> Floats32 | None:
    """Signed distance (rows, cols) to live obstacles in their window, m; None without any.

    Cached: the layer returns the same object while nothing changes.
    """
    if not live.occupied.any():
        return None
    return signed_distance(live.occupied > 0, resolution)
