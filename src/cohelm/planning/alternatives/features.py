"""Features of a route: figures with units, and few enough to be explained."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Floats32, value
from cohelm.config import Model
from cohelm.geometry import inverse, resample, transform, wrap_angle
from cohelm.kernels import CACHED, callee
from cohelm.maps import DistanceField
from cohelm.maps.distance import sample
from cohelm.messages import Crowding, Path
from cohelm.planning.problem import PreparedProblem
from cohelm.planning.reference import ComfortLimits, ReferenceSettings, make_reference

_SPACING = 0.1  # m between the points that a route is measured at


class FeatureParameters(Model):
    """Parameters of the features; assumed."""

    speed: float = Field(0.8, gt=0.0, le=3.0)
    """The rider's cruising speed, m/s; see ``RiderProfile.preferred_speed``."""
    comfort: ComfortLimits = ComfortLimits()
    door_width: float = Field(1.3, gt=0.0, le=5.0)
    """Passages narrower than this count as doors, m; clear widths of doors are 0.8 to 1.2 m."""
    roomy: float = Field(2.0, gt=0.0, le=20.0)
    """Clearance above which more makes no difference, m."""
    turn_deg: float = Field(30.0, gt=0.0, le=180.0)
    """A turn is a change of heading of at least this within a few metres, degrees."""
    near: float = Field(2.0, gt=0.0, le=10.0)
    """Width of the band along the route in which people are met, m."""


@value
class RouteFeatures:
    """Features of a route. Slopes are missing, because maps have no heights."""

    length: float
    """m."""
    time: float
    """Travel time from standstill to standstill, with the robot's limits and slower curves, s."""
    clearance_min: float
    """Minimum distance of the robot's centre to an obstacle, m."""
    clearance: float
    """Mean distance to the nearest obstacle, limited to ``FeatureParameters.roomy``, m."""
    crowding: float
    """Mean recent density of people, people/m²."""
    encounters: float
    """Number of people near the route: density summed over the band along it."""
    turns: int
    """Changes of heading of ``FeatureParameters.turn_deg`` and more."""
    heading_change: float
    """Sum of |change of heading|, without small oscillations of the line, rad."""
    doors: int
    """Number of passages as narrow as a door, at any angle of crossing."""


def route_features(
    prepared: PreparedProblem, path: Path, measuring: FeatureParameters | None = None
) -> RouteFeatures:
    """Features of a path on the problem that it was planned for."""
    measuring = measuring or FeatureParameters()
    grid, clearance = prepared.costmap.grid, prepared.costmap.clearance
    field = DistanceField(distance=clearance, resolution=grid.resolution, X_MG=grid.X_MG)
    points = resample(path.points, _SPACING)
    line = transform(inverse(grid.X_MG), points)
    room = field.at(points)
    crowding = _crowding(prepared.problem.crowding, points)
    turns = _turns(points)
    return RouteFeatures(
        length=path.length,
        time=travel_time(prepared, path, measuring),
        clearance_min=float(room.min()),
        clearance=float(np.minimum(room, measuring.roomy).mean()),
        crowding=crowding,
        encounters=crowding * path.length * measuring.near,
        turns=int((np.abs(turns) >= math.radians(measuring.turn_deg)).sum()),
        heading_change=float(np.abs(turns).sum()),
        doors=narrow_passages(prepared.costmap.walls, grid.resolution, line, measuring.door_width),
    )


def travel_time(prepared: PreparedProblem, path: Path, measuring: FeatureParameters) -> float:
    """Travel time of a path without people in the way, s: the reference followed exactly."""
    robot = prepared.problem.robot
    if path.length <= 0.0:
        return 0.0
    step = 0.1
    steps = math.ceil(2.0 * path.length / (min(measuring.speed, robot.max_speed) * step)) + 200
    heading = math.atan2(*(path.points[1] - path.points[0])[::-1])
    pose = np.array([*path.points[0], heading])
    for _ in range(8):
        settings = ReferenceSettings(
            steps=steps,
            step=step,
            speed=measuring.speed,
            robot=robot,
            comfort=measuring.comfort,
        )
        along, _ = make_reference(path, pose, np.zeros(3), settings, progress=0.0)
        moving = np.flatnonzero((along.poses[:, :2] != along.poses[-1, :2]).any(axis=1))
        if along.speeds[-1] == 0.0 and len(moving) < steps:
            break
        steps *= 2
    return float(len(moving) * step)


def _crowding(crowding: Crowding | None, points: Floats) -> float:
    """Mean density at the points (k, 2), people/m²; 0 where it is unknown."""
    if crowding is None:
        return 0.0
    cells = np.floor(transform(inverse(crowding.X_MG), points)[:, ::-1] / crowding.resolution)
    inside = ((cells >= 0) & (cells < crowding.density.shape)).all(axis=1)
    row, col = cells[inside].astype(np.int64).T
    return float(crowding.density[row, col].sum()) / len(points)


def _turns(points: Floats) -> Floats:
    """Turns along a line (k, 2), rad, each summed over its curve.

    The line is sampled every metre, which hides small oscillations; changes to the same side within
    three metres of each other are one turn.
    """
    steps = np.diff(resample(points, 1.0), axis=0)
    change = wrap_angle(np.diff(np.arctan2(steps[:, 1], steps[:, 0])))
    at = np.flatnonzero(np.abs(change) > math.radians(5.0))
    if not len(at):
        return np.empty(0)
    change = change[at]
    apart = (np.sign(change[1:]) != np.sign(change[:-1])) | (np.diff(at) > 3)
    return np.add.reduceat(change, np.flatnonzero(np.concatenate([[True], apart])))


_SAME = 1.0  # m; crossings closer than this belong to one passage


@njit(**CACHED)
def narrow_passages(walls: Floats32, resolution: float, line: Floats, width: float) -> int:
    """Count the passages narrower than ``width`` that a line comes through, at any angle.

    A passage is where the line crosses between two points of walls that face each other: the disc
    between them is free, so they are the narrowest place and not two walls of one corner.

    Args:
        walls: distance to physical obstacles (rows, cols), m; negative inside.
        resolution: of the grid, m.
        line: (k, 2), grid's frame, points closer than a metre, m.
        width: between the surfaces on either side, m.
    """
    count, since = 0, np.inf
    for i in range(line.shape[0] - 1):
        step = line[i + 1] - line[i]
        length = math.hypot(step[0], step[1])
        if length == 0.0:
            continue
        if _between_walls(walls, resolution, line[i], step / length, length, width):
            count += since > _SAME
            since = 0.0
        else:
            since += length
    return count


@callee()
def _between_walls(
    walls: Floats32, resolution: float, point: Floats, ahead: Floats, length: float, width: float
) -> bool:
    """Check that a straight step crosses a passage narrower than ``width``."""
    room, _, _ = sample(walls, resolution, np.zeros(3), point[0], point[1])
    if room > 0.5 * width + length:
        return False
    left = _surface(walls, resolution, point, ahead, length + width, 1.0)
    if left.shape[0] == 0:
        return False
    right = _surface(walls, resolution, point, ahead, length + width, -1.0)
    for a in left:
        for b in right:
            dx = max(abs(a[2] - b[2]) - resolution, 0.0)
            dy = max(abs(a[3] - b[3]) - resolution, 0.0)
            apart = math.hypot(dx, dy)
            if apart >= width:
                continue
            crossed = (a[0] * b[1] + b[0] * a[1]) / (a[1] + b[1])
            if not 0.0 <= crossed < length:
                continue
            middle, _, _ = sample(
                walls, resolution, np.zeros(3), 0.5 * (a[2] + b[2]), 0.5 * (a[3] + b[3])
            )
            if middle >= 0.5 * apart - resolution:
                return True
    return False


@callee()
def _surface(
    walls: Floats32, resolution: float, point: Floats, ahead: Floats, reach: float, side: float
) -> Floats:
    """(ahead, aside, x, y) of the centres of cells at walls' surfaces on one side, (n, 4), m."""
    rows, cols = walls.shape
    size = math.ceil(reach / resolution)
    row, col = math.floor(point[1] / resolution), math.floor(point[0] / resolution)
    out = np.empty((4 * size * size + 4 * size + 1, 4))
    count = 0
    for r in range(max(row - size, 0), min(row + size + 1, rows)):
        c = max(col - size, 0)
        while c < min(col + size + 1, cols):
            room = np.float64(walls[r, c])
            if -1.5 * resolution < room < 0.0:
                x, y = (c + 0.5) * resolution, (r + 0.5) * resolution
                dx, dy = x - point[0], y - point[1]
                aside = side * (ahead[0] * dy - ahead[1] * dx)
                if aside > 0.0:
                    out[count, 0], out[count, 1] = ahead[0] * dx + ahead[1] * dy, aside
                    out[count, 2], out[count, 3] = x, y
                    count += 1
            c += max(1, int(room / resolution))
    return out[:count]
