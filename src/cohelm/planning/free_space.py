"""Check that a robot fits at a point of a map, and find the nearest point where it does."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import inverse, transform
from cohelm.maps import DistanceField, OccupancyGrid, distance_field
from cohelm.planning.path_refinement.footprint import FootprintModel, footprint_model, overlaps
from cohelm.robots import Robot

HEADINGS = 64
"""Headings that are tried where none is given."""


class FreeSpaceCheck(NamedTuple):
    """Result of :func:`check_free_space` at one point."""

    point: tuple[float, float]
    """Map frame, m."""
    clearance: float
    """Distance to the nearest blocked cell, m; 0 within one, NaN off the map."""
    fits: bool
    """True where the footprint overlaps no blocked cell at the heading, or at one of several."""
    turns: bool
    """True where the footprint fits at every heading, so that the robot can turn on the spot."""
    nearest: tuple[float, float] | None
    """Nearest point with the clearance that a goal needs, m; None: there is none."""


def check_free_space(
    grid: OccupancyGrid,
    robot: Robot,
    point: tuple[float, float],
    heading: float | None = None,
    *,
    clearance: float = 0.0,
    field: DistanceField | None = None,
) -> FreeSpaceCheck:
    """Check that a robot fits at a point, with its footprint and not with a circle about it.

    Args:
        grid: Occupied and unknown cells block.
        robot: Its footprint is used.
        point: Position of the drive axle's centre, map frame, m.
        heading: In the map frame, rad; None: any heading will do.
        clearance: Distance that the inscribed circle of a goal must keep from obstacles, m.
        field: Distance field of the grid, where it is known already.
    """
    field = field or distance_field(grid)
    body = footprint_model(robot.outline, field.distance, field.resolution)
    directions: Floats = np.linspace(0.0, math.tau, HEADINGS, endpoint=False)
    asked = directions if heading is None else np.array([heading - float(grid.X_MG[2])])
    at = np.array(point, dtype=float)
    radius = robot.inscribed_radius + clearance
    if not (np.isfinite(at).all() and bool(grid.contains(at))):
        return FreeSpaceCheck(
            point, math.nan, False, False, _nearest(grid, radius, at, body, asked)
        )
    x, y = transform(inverse(grid.X_MG), at)
    fits = _fits(body, x, y, asked)
    return FreeSpaceCheck(
        point=point,
        clearance=max(float(field.at(at)), 0.0),
        fits=fits,
        turns=fits and not any(overlaps(body, x, y, angle) for angle in directions),
        nearest=_nearest(grid, radius, at, body, asked),
    )


def _fits(body: FootprintModel, x: float, y: float, headings: Floats) -> bool:
    return any(not overlaps(body, x, y, angle) for angle in headings)


def _nearest(
    grid: OccupancyGrid, radius: float, point: Floats, body: FootprintModel, headings: Floats
) -> tuple[float, float] | None:
    """Return the point, or the centre of the nearest cell, where the robot fits and may stop."""
    if not np.isfinite(point).all():
        return None
    # Global planners refuse a goal in a cell that is closer to an obstacle than this.
    allowed = body.clearance > radius
    if bool(grid.contains(point)) and allowed[tuple(grid.cells(point))]:
        x, y = transform(inverse(grid.X_MG), point)
        if _fits(body, x, y, headings):
            return float(point[0]), float(point[1])
    cells = np.argwhere(allowed)
    centres = (cells[:, ::-1] + 0.5) * grid.resolution
    distance = np.hypot(*(centres - transform(inverse(grid.X_MG), point)).T)
    for k in np.argsort(distance, kind="stable"):
        x, y = centres[k]
        if _fits(body, x, y, headings):
            found = transform(grid.X_MG, centres[k])
            return float(found[0]), float(found[1])
    return None
