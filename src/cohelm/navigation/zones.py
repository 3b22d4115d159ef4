"""Masks in the ride: where the chair must not be, and how slow it must be.

A keepout zone is a wall to the local planner and to the gate (in ``Mode.MANUAL`` the gate minds no
walls, and so none of these), while perception is given the true map: nothing stands there, and who
walks there is seen. A speed limit holds where the chair is, and is looked for ahead, so that the
chair is slow on entering.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.geometry import resample, transform
from cohelm.maps import OCCUPIED, CostmapFilter, OccupancyGrid
from cohelm.maps.masks import closed_cells, speed_limit_at
from cohelm.messages import Mode, Observation, Request
from cohelm.navigation.ahead import rest_of
from cohelm.navigation.replanning import RouteState
from cohelm.robots import Robot

_SPACING = 0.1
"""Between points at which limits are read, m."""


class ZoneParameters(Model):
    """How the chair comes to a speed limit; assumed."""

    deceleration: float = Field(0.5, gt=0.0, le=10.0)
    """Of braking for a limit ahead, m/s²; never more than the robot's."""
    reaction: float = Field(0.4, ge=0.0, le=5.0)
    """How much sooner the braking begins than it would have to, s: ticks and the drive's lag."""
    margin: float = Field(0.1, ge=0.0, le=2.0)
    """Distance before the zone at which its limit holds already, m: the pose is no more exact."""


def walled(grid: OccupancyGrid, filters: tuple[CostmapFilter, ...]) -> OccupancyGrid:
    """The grid with keepout zones as if they were walls; itself where there are none."""
    closed = closed_cells(filters, grid)
    if not closed.any():
        return grid
    data = grid.data.copy()
    data[closed] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def limited(
    request: Request,
    filters: tuple[CostmapFilter, ...],
    robot: Robot,
    observation: Observation,
    route: RouteState | None,
    parameters: ZoneParameters,
) -> Request:
    """The request with the speed limit that the masks set here and ahead; itself if they set none.

    v ≤ √(L² + 2 b s), with s the way to a place with limit L, less margin and reaction, and b the
    deceleration: from everywhere the chair can be as slow as the place wants when it comes there.

    Args:
        request: what is wanted.
        filters: masks of any type.
        robot: its full speed and brakes.
        observation: where the chair is and how fast.
        route: that is followed where the chair steers itself; the rider alone goes straight on.
        parameters: how the chair comes to a limit.
    """
    if all(f.type == "keepout" for f in filters):
        return request
    p, full, speed = parameters, robot.max_speed, float(observation.twist[0])
    brake = min(p.deceleration, robot.max_deceleration)
    early = p.margin + p.reaction * abs(speed)
    reach = early + 0.5 * full * full / brake
    away, points = _ahead(request, observation.pose, route, reach, backwards=speed < 0.0)
    limits = np.array([speed_limit_at(filters, point, full) for point in points])
    allowed = np.sqrt(limits**2 + 2.0 * brake * np.maximum(away - early, 0.0))
    least = float(allowed[limits < full].min(initial=math.inf))
    if least >= request.speed_limit:
        return request
    return replace(request, speed_limit=least)


def _ahead(
    request: Request, pose: Floats, route: RouteState | None, reach: float, *, backwards: bool
) -> tuple[Floats, Floats]:
    """(distance (k,), points (k, 2)) of where the chair will be within ``reach``, m, itself first.

    Straight on, and along the path where the chair follows one.
    """
    steps = np.arange(0.0, reach + _SPACING, _SPACING)
    way = -steps if backwards else steps
    straight = transform(pose, np.stack([way, np.zeros(len(steps))], axis=-1))
    if route is None or request.mode in {Mode.MANUAL, Mode.ASSISTED}:
        return steps, straight
    line = resample(rest_of(route.path, route.progress), _SPACING)[: len(steps)]
    along = _SPACING * np.arange(len(line))
    points = np.concatenate([pose[None, :2], line])
    return np.concatenate([[0.0], along]), points
