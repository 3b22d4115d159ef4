"""View of a seated rider: people in sight and free distances.

Walls and objects hide the people behind them, even if they are low; people hide no one. The limits
are assumed: eyes and neck together cover more than the front of the chair.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.simulation.api import Crowd
from cohelm.simulation.sensors.grid_raycast import cast, in_sight
from cohelm.simulation.wall_geometry import walls_of

FIELD = math.radians(110.0)
"""Half the field of view, rad: of the eyes, and a turn of the head."""
PEOPLE_RANGE = 10.0
"""Distance up to which a rider sees people, m."""
OBSTACLE_RANGE = 5.0
"""Distance up to which a rider sees walls and objects, m."""
DIRECTIONS = np.linspace(-FIELD, FIELD, 45)
"""Viewing directions, 5° apart, rad."""
_NO_DISCS = np.empty((0, 3))


def view_from(
    grid: OccupancyGrid, pose: Floats, crowd: Crowd, kept_clear: OccupancyGrid | None = None
) -> tuple[Floats, Floats]:
    """Compute the view from the origin of a chair at ``pose`` (3,), X_MR.

    Args:
        grid: true obstacles.
        pose: of the chair.
        crowd: true people.
        kept_clear: obstacles and floor that the rider avoids, which end a free distance but hide
            nobody; None: the true obstacles alone.

    Returns:
        People in sight, (n, 5) as (x, y, v_x, v_y, radius) in the chair's frame; and the free
        distance along ``DIRECTIONS``, (b,), m, +inf beyond ``OBSTACLE_RANGE``.
    """
    blocked = walls_of(grid, unknown=False).solid
    ends = walls_of(kept_clear or grid, unknown=False).solid
    free = cast(ends, grid.resolution, grid.X_MG, _NO_DISCS, pose, DIRECTIONS, OBSTACLE_RANGE)
    position = transform(inverse(pose), crowd.position)
    visible = np.hypot(*position.T) <= PEOPLE_RANGE
    visible &= np.abs(np.arctan2(position[:, 1], position[:, 0])) <= FIELD
    if visible.any():
        to = crowd.position[visible]
        eyes = np.broadcast_to(pose[:2], to.shape)
        visible[visible] = in_sight(blocked, grid.resolution, grid.X_MG, eyes.copy(), to)
    velocity = transform([0.0, 0.0, -pose[2]], crowd.velocity)
    return np.column_stack([position, velocity, crowd.radius])[visible], free
