"""Small scenes for the checks: rooms, people, scans and references with known answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem
from cohelm.geometry import compose, transform
from cohelm.maps import FREE, OCCUPIED, DistanceField, OccupancyGrid, distance_field
from cohelm.messages import People, Predictions, Reference, Scan, SocialSpaces
from cohelm.robots import Robot, load_robot
from cohelm.shapes import CONTOUR

RESOLUTION = 0.05
"""Side of a cell of every room, m."""
BODY = 0.25
"""Radius of all people, m."""


def room(
    width: float = 12.0,
    height: float = 8.0,
    *,
    boxes: ArrayLike = (),
    walls: bool = True,
) -> OccupancyGrid:
    """Room with its lower left corner at the map's origin.

    Args:
        width, height: outer size, m.
        boxes: (x_min, y_min, x_max, y_max) of obstacles, (b, 4), m.
        walls: True where the border cells are a wall, 0.1 m thick.
    """
    data = np.full((round(height / RESOLUTION), round(width / RESOLUTION)), FREE, dtype=np.int8)
    if walls:
        data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = OCCUPIED
    for x0, y0, x1, y1 in np.reshape(np.asarray(boxes, dtype=float), (-1, 4)) / RESOLUTION:
        data[round(y0) : round(y1), round(x0) : round(x1)] = OCCUPIED
    return OccupancyGrid(data=data, resolution=RESOLUTION, X_MG=np.zeros(3))


def open_floor(X_MG: ArrayLike = (-20.0, -20.0, 0.0)) -> DistanceField:
    """Floor of 40 × 40 m without obstacles, by default around the map's origin."""
    distance = np.full((40, 40), 40.0, dtype=np.float32)
    return DistanceField(distance=distance, resolution=1.0, X_MG=np.asarray(X_MG, dtype=float))


def walkers(mean: ArrayLike, *, time: float = 0.0, source: str = "tracker") -> People:
    """People of radius ``BODY`` with states ``mean`` (n, 4), standard deviation 5 cm.

    Standing people have an unknown heading.
    """
    states = np.asarray(mean, dtype=float).reshape(-1, 4)
    n = len(states)
    at_rest = np.hypot(states[:, 2], states[:, 3]) < 0.05
    heading = np.arctan2(states[:, 3], states[:, 2])
    return People(
        time=time,
        id=np.arange(1, n + 1),
        mean=states,
        covariance=np.tile(np.diag([0.05, 0.05, 0.1, 0.1]) ** 2, (n, 1, 1)),
        heading=np.where(at_rest, np.nan, heading),
        radius=np.full(n, BODY),
        confidence=np.ones(n),
        source=source,
    )


def straight_on(people: People, steps: int, step: float) -> Predictions:
    """Predict that all people walk straight on; the deviation grows by 0.1 m/s."""
    n = len(people)
    ahead = np.arange(steps + 1) * step
    position, velocity = people.mean[:, None, None, :2], people.mean[:, None, None, 2:]
    return Predictions(
        step=step,
        names=("straight_on",),
        weight=np.ones((n, 1)),
        mean=position + velocity * ahead[:, None],
        velocity=np.broadcast_to(velocity, (n, 1, steps + 1, 2)),
        deviation=np.broadcast_to(0.05 + 0.1 * ahead, (n, 1, steps + 1)),
    )


def round_spaces(predictions: Predictions, *, reach: float = 0.45) -> SocialSpaces:
    """Return a circle of ``reach`` m about each person at any speed, and none about the robot."""
    circle = np.full(predictions.deviation.shape, 0.1)
    return SocialSpaces(
        kind=CONTOUR,
        scale=0.5,
        axis=np.zeros(circle.shape),
        front=circle,
        side=circle,
        rear=circle,
        floor=reach,
        robot=np.full(3, 0.1),
    )


def straight_reference(pose: Floats, speed: float, steps: int, step: float) -> Reference:
    """Straight ahead of ``pose`` at ``speed``."""
    ahead = np.zeros((steps + 1, 3))
    ahead[:, 0] = speed * step * np.arange(steps + 1)
    poses = compose(pose, ahead)
    poses[:, 2] = pose[2]
    return Reference(step=step, poses=poses, speeds=np.full(steps + 1, speed))


def local_problem(  # as many arguments as a problem has parts
    *,
    steps: int,
    step: float,
    people: People | None = None,
    walls: DistanceField | None = None,
    pose: ArrayLike = (0.0, 0.0, 0.0),
    speed: float = 0.0,
    wanted: float = 0.8,
    robot: Robot | None = None,
) -> LocalProblem:
    """Problem of a chair that drives straight ahead at ``speed`` and prefers ``wanted``, m/s."""
    here = np.asarray(pose, dtype=float)
    who = People.empty(0.0) if people is None else people
    predictions = straight_on(who, steps, step)
    return LocalProblem(
        time=0.0,
        robot=load_robot("quantum_q6_edge") if robot is None else robot,
        pose=here,
        twist=np.array([speed, 0.0, 0.0]),
        reference=straight_reference(here, wanted, steps, step),
        people=who,
        predictions=predictions,
        spaces=round_spaces(predictions),
        walls=open_floor() if walls is None else walls,
        speed_limit=1.0,
    )


def walls_of(grid: OccupancyGrid) -> DistanceField:
    """Distance field of a room."""
    return distance_field(grid)


def scan_of(  # one argument for each thing that a scan sees
    *,
    pose: ArrayLike,
    size: tuple[float, float] = (12.0, 8.0),
    discs: ArrayLike = (),
    time: float = 0.0,
    beams: int = 720,
    range_max: float = 10.0,
    mount: ArrayLike = (0.0, 0.0, 0.0),
) -> Scan:
    """Scan of round bodies (b, 3: x, y, radius) in an empty :func:`room` by a perfect scanner.

    In closed form and independent of the simulator: the wall's inner face is 0.1 m inside ``size``;
    a beam ends where it first meets the wall or a disc.
    """
    X_ML = compose(np.asarray(pose, dtype=float), np.asarray(mount, dtype=float))
    angle = -np.pi + 2.0 * np.pi * np.arange(beams) / beams
    direction = transform(
        np.array([0.0, 0.0, X_ML[2]]), np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    )
    faces = np.where(direction > 0.0, np.asarray(size) - 0.1, 0.1)
    along = np.where(np.abs(direction) > 1e-12, direction, np.inf)
    ranges = np.where(np.isinf(along), np.inf, (faces - X_ML[:2]) / along).min(axis=-1)
    for x, y, radius in np.reshape(np.asarray(discs, dtype=float), (-1, 3)):
        to_centre = np.array([x, y]) - X_ML[:2]
        middle = direction @ to_centre
        half = radius**2 - (to_centre @ to_centre - middle**2)
        hit = (half > 0.0) & (middle > 0.0)
        met = middle - np.sqrt(np.where(hit, half, 0.0))
        ranges = np.where(hit, np.minimum(ranges, met), ranges)
    return Scan(
        time=time,
        mount=np.asarray(mount, dtype=float),
        angle_min=-np.pi,
        angle_increment=2.0 * np.pi / beams,
        range_max=range_max,
        ranges=np.where(ranges > range_max, np.inf, ranges),
    )
