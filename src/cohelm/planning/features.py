"""What a route is like to ride: figures with units, and small enough a set to be explained."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, value
from cohelm.config import Model
from cohelm.geometry import inverse, resample, transform, wrap_angle
from cohelm.maps import DistanceField
from cohelm.messages import Crowding, Path
from cohelm.planning.doors import narrow_passages
from cohelm.planning.ground import Ground
from cohelm.planning.reference import Comfort, reference

_SPACING = 0.1  # m between the points that a route is measured at


class Measuring(Model):
    """How a route is measured; the figures are assumed."""

    speed: float = Field(0.8, gt=0.0, le=3.0)
    """The rider's cruising speed, m/s; see ``RiderProfile.preferred_speed``."""
    comfort: Comfort = Comfort()
    door_width: float = Field(1.3, gt=0.0, le=5.0)
    """A passage narrower than this is as a door, m; clear widths of doors are 0.8 to 1.2 m."""
    roomy: float = Field(2.0, gt=0.0, le=20.0)
    """More clearance than this does not feel roomier, m."""
    turn_deg: float = Field(30.0, gt=0.0, le=180.0)
    """A turn is a change of heading of at least this within a few metres, degrees."""
    near: float = Field(2.0, gt=0.0, le=10.0)
    """Width of the band along the route in which people are met, m."""


@value
class RouteFeatures:
    """What a route is like. Slopes are not among it: maps do not know heights."""

    length: float
    """m."""
    time: float
    """From standstill to standstill with the robot's limits, slower in curves, s."""
    clearance_min: float
    """Least distance of the robot's centre to an obstacle, m."""
    clearance: float
    """Mean distance to the nearest obstacle, what is beyond ``Measuring.roomy`` not counted, m."""
    crowding: float
    """Mean density of people lately, people/m²."""
    encounters: float
    """How many people are near the way: density summed over the band along it, people."""
    turns: int
    """Changes of heading of ``Measuring.turn_deg`` and more."""
    heading_change: float
    """Sum of |change of heading|, without the wobble of the line, rad."""
    doors: int
    """Passages as narrow as a door, however aslant they are taken."""


def route_features(ground: Ground, path: Path, measuring: Measuring | None = None) -> RouteFeatures:
    """The figures of a path over the ground that it was planned on."""
    measuring = measuring or Measuring()
    grid, clearance = ground.costmap.grid, ground.costmap.clearance
    field = DistanceField(distance=clearance, resolution=grid.resolution, X_MG=grid.X_MG)
    points = resample(path.points, _SPACING)
    line = transform(inverse(grid.X_MG), points)
    room = field.at(points)
    crowding = _crowding(ground.problem.crowding, points)
    turns = _turns(points)
    return RouteFeatures(
        length=path.length,
        time=travel_time(ground, path, measuring),
        clearance_min=float(room.min()),
        clearance=float(np.minimum(room, measuring.roomy).mean()),
        crowding=crowding,
        encounters=crowding * path.length * measuring.near,
        turns=int((np.abs(turns) >= math.radians(measuring.turn_deg)).sum()),
        heading_change=float(np.abs(turns).sum()),
        doors=narrow_passages(ground.costmap.walls, grid.resolution, line, measuring.door_width),
    )


def travel_time(ground: Ground, path: Path, measuring: Measuring) -> float:
    """How long a path takes without anybody in the way, s: the reference followed exactly."""
    robot = ground.problem.robot
    if path.length <= 0.0:
        return 0.0
    step = 0.1
    steps = math.ceil(2.0 * path.length / (min(measuring.speed, robot.max_speed) * step)) + 200
    heading = math.atan2(*(path.points[1] - path.points[0])[::-1])
    pose = np.array([*path.points[0], heading])
    for _ in range(8):
        along, _ = reference(
            path, pose, np.zeros(3), steps=steps, step=step,
            speed=measuring.speed, robot=robot, progress=0.0, comfort=measuring.comfort,
        )  # fmt: skip
        on_the_way = np.flatnonzero((along.poses[:, :2] != along.poses[-1, :2]).any(axis=1))
        if along.speeds[-1] == 0.0 and len(on_the_way) < steps:
            break
        steps *= 2
    return float(len(on_the_way) * step)


def _crowding(crowding: Crowding | None, points: Floats) -> float:
    """Mean density at the points (k, 2), people/m²; nobody where nothing is known."""
    if crowding is None:
        return 0.0
    cells = np.floor(transform(inverse(crowding.X_MG), points)[:, ::-1] / crowding.resolution)
    inside = ((cells >= 0) & (cells < crowding.density.shape)).all(axis=1)
    row, col = cells[inside].astype(np.int64).T
    return float(crowding.density[row, col].sum()) / len(points)


def _turns(points: Floats) -> Floats:
    """The changes of heading along a line (k, 2), rad, each gathered over its curve.

    The line is taken at every metre, which hides its wobble; changes to the same side within three
    metres of each other are one turn.
    """
    steps = np.diff(resample(points, 1.0), axis=0)
    change = wrap_angle(np.diff(np.arctan2(steps[:, 1], steps[:, 0])))
    at = np.flatnonzero(np.abs(change) > math.radians(5.0))
    if not len(at):
        return np.empty(0)
    change = change[at]
    apart = (np.sign(change[1:]) != np.sign(change[:-1])) | (np.diff(at) > 3)
    return np.add.reduceat(change, np.flatnonzero(np.concatenate([[True], apart])))
