"""What a seated rider sees: who is in sight, and how far the floor is free all about.

Walls and things hide whoever stands behind them, however low they are; people hide nobody. The
figures are assumed: eyes and neck together take in more than what lies before the chair.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.simulation.api import Crowd, Rider
from cohelm.simulation.sensors.raycast import cast, in_sight
from cohelm.simulation.walls import walls_of

FIELD = math.radians(110.0)
"""How far to either side a rider sees, rad: the eyes' field of view and a turn of the head."""
REACH = 10.0
"""How far a rider heeds people, m."""
NEAR = 5.0
"""How far a rider heeds walls and things, m."""
GLANCES = np.linspace(-FIELD, FIELD, 45)
"""Directions in which a rider looks for a free way, 5° apart, rad."""


def seen_by(
    rider: Rider, grid: OccupancyGrid, pose: Floats, crowd: Crowd
) -> tuple[Floats, Floats, Floats]:
    """Who is in sight, (n, 5), the directions of the glances and how far it is free there, (b,).

    Nothing of it for a rider that never looks about. See :func:`look`.
    """
    if not getattr(rider, "looks", True):
        return _NOTHING_SEEN
    people, free = look(grid, pose, crowd)
    return people, GLANCES, free


def look(grid: OccupancyGrid, pose: Floats, crowd: Crowd) -> tuple[Floats, Floats]:
    """What is in sight of the rider of a chair at ``pose`` (3,), X_MR.

    Args:
        grid: what truly stands there.
        pose: of the chair; the rider's eyes are over its origin.
        crowd: who is there.

    Returns:
        Who is in sight, (n, 5) as (x, y, v_x, v_y, radius) in the chair's frame; and how far the
        floor is free along ``GLANCES``, (b,), m, +inf beyond ``NEAR``.
    """
    blocked = walls_of(grid, unknown=False).solid
    free = cast(blocked, grid.resolution, grid.X_MG, _NOBODY, pose, GLANCES, NEAR)
    place = transform(inverse(pose), crowd.position)
    seen = np.hypot(*place.T) <= REACH
    seen &= np.abs(np.arctan2(place[:, 1], place[:, 0])) <= FIELD
    if seen.any():
        to = crowd.position[seen]
        eyes = np.broadcast_to(pose[:2], to.shape)
        seen[seen] = in_sight(blocked, grid.resolution, grid.X_MG, eyes.copy(), to)
    turned = transform([0.0, 0.0, -pose[2]], crowd.velocity)
    return np.column_stack([place, turned, crowd.radius])[seen], free


_NOBODY = np.empty((0, 3))
_NOTHING_SEEN = (np.empty((0, 5)), np.empty(0), np.empty(0))
"""What :func:`seen_by` tells who does not look."""
