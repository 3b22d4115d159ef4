"""Keepout zones and speed limits during a ride (Nav2's costmap filters).

A keepout zone is a wall to the local planner and to the gate (in ``Mode.MANUAL`` the gate ignores
walls, and so these). Perception uses the true map: people who walk there are detected. A speed
limit applies at the chair and ahead of it, so that the chair is slow when it enters.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, replace
from cohelm.config import Model
from cohelm.geometry import resample, transform
from cohelm.maps import OCCUPIED, CostmapFilter, OccupancyGrid
from cohelm.maps.masks import closed_cells, speed_limit_at
from cohelm.messages import Observation, Request
from cohelm.navigation.replanning.remaining_path import remaining_path
from cohelm.navigation.replanning.replanner import RouteState
from cohelm.robots import Robot

_SPACING = 0.1
"""Spacing of points at which limits are read, m."""


class ZoneParameters(Model):
    """Approach of a speed limit; assumed."""

    deceleration: float = Field(0.5, gt=0.0, le=10.0)
    """Deceleration for a limit ahead, m/s²; at most the robot's."""
    reaction: float = Field(0.4, ge=0.0, le=5.0)
    """Time by which braking begins early, s: ticks and lag of the drive."""
    margin: float = Field(0.1, ge=0.0, le=2.0)
    """Distance before the zone at which its limit already applies, m: error of the pose."""


def with_keepout_walls(grid: OccupancyGrid, filters: tuple[CostmapFilter, ...]) -> OccupancyGrid:
    """Add keepout zones to the grid as walls; returns the grid itself if there are none."""
    closed = closed_cells(filters, grid)
    if not closed.any():
        return grid
    data = grid.data.copy()
    data[closed] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def with_zone_limits(
    request: Request,
    filters: tuple[CostmapFilter, ...],
    robot: Robot,
    observation: Observation,
    route: RouteState | None,
    parameters: ZoneParameters,
) -> Request:
    """Add the speed limit of the masks here and ahead; returns the request itself if there is none.

    v ≤ √(L² + 2 b s), with s the distance to a place with limit L, less margin and reaction, and b
    the deceleration, so that the chair reaches every place at no more than its limit.

    Args:
        request: goal, mode and limits.
        filters: masks of any type.
        robot: its maximum speed and deceleration.
        observation: pose and speed.
        route: followed if the chair steers; a rider who drives alone goes straight on.
        parameters: approach of a limit.
    """
    if all(f.type == "keepout" for f in filters):
        return request
    p, full, speed = parameters, robot.max_speed, float(observation.twist[0])
    brake = min(p.deceleration, robot.max_deceleration)
    early = p.margin + p.reaction * abs(speed)
    extent = early + 0.5 * full * full / brake
    distances, points = _ahead(request, observation.pose, route, extent, backwards=speed < 0.0)
    limits = np.array([speed_limit_at(filters, point, full) for point in points])
    allowed = np.sqrt(limits**2 + 2.0 * brake * np.maximum(distances - early, 0.0))
    limit = float(allowed[limits < full].min(initial=math.inf))
    return request if limit >= request.speed_limit else replace(request, speed_limit=limit)


def _ahead(
    request: Request, pose: Floats, route: RouteState | None, extent: float, *, backwards: bool
) -> tuple[Floats, Floats]:
    """Distances (k,) and points (k, 2) that the chair will pass within ``extent``, m, itself first.

    Straight on, or along the path if the chair follows one.
    """
    steps = np.arange(0.0, extent + _SPACING, _SPACING)
    travelled = -steps if backwards else steps
    straight = transform(pose, np.stack([travelled, np.zeros(len(steps))], axis=-1))
    if route is None or request.mode.rider_drives:
        return steps, straight
    line = resample(remaining_path(route.path, route.progress), _SPACING)[: len(steps)]
    along = _SPACING * np.arange(len(line))
    points = np.concatenate([pose[None, :2], line])
    return np.concatenate([[0.0], along]), points
