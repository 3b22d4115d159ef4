"""Observations in good order, and floors whose distances are known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.maps import DistanceField
from cohelm.messages import Mode, Observation, People, PointCloud, Request, RiderCommand, Scan
from cohelm.testing.scenes import open_floor, straight_on, walkers

NOW = 10.0


def scan(time: float = NOW, ranges: object = (1.0, 2.0, np.inf, 3.0)) -> Scan:
    """A sweep of a few beams."""
    return Scan(
        time=time,
        mount=np.zeros(3),
        angle_min=-np.pi,
        angle_increment=np.pi / 2.0,
        range_max=10.0,
        ranges=np.asarray(ranges, dtype=float),
    )


def cloud(
    time: float = NOW, points: object = ((1.0, 0.0, 0.0),), mount: object = (0.0,) * 6
) -> PointCloud:
    """A sweep of a few points."""
    return PointCloud(
        time=time,
        mount=np.asarray(mount, dtype=float),
        points=np.asarray(points, dtype=np.float32).reshape(-1, 3),
        range_max=10.0,
    )


def sound(time: float = NOW, *, speed: float = 0.0, **changes: object) -> Observation:
    """Everything fresh at ``time``: a chair that drives ahead, its rider's hand at rest."""
    good = Observation(
        time=time,
        pose=np.zeros(3),
        pose_time=time,
        twist=np.array([speed, 0.0, 0.0]),
        twist_time=time,
        scans=(scan(time),),
        rider=RiderCommand(heartbeat=time, deflection=np.zeros(2)),
    )
    return replace(good, **changes)


def request(mode: Mode = Mode.SHARED, **changes: object) -> Request:
    """To go somewhere."""
    return Request(goal=np.array([5.0, 0.0]), mode=mode, **changes)


def wall_at(x: float) -> DistanceField:
    """A wall across, whose surface is at ``x``; bilinear sampling of its field is exact."""
    field = open_floor()
    rows, cols = field.distance.shape
    centres = field.X_MG[0] + (np.arange(cols) + 0.5) * field.resolution
    distance = np.broadcast_to(x - centres, (rows, cols)).astype(np.float32)
    return replace(field, distance=distance)


def surroundings(
    walls: DistanceField | None = None, people: People | None = None
) -> dict[str, object]:
    """What the gate asks about."""
    who = walkers(np.empty((0, 4))) if people is None else people
    return {
        "walls": open_floor() if walls is None else walls,
        "people": who,
        "predictions": straight_on(who, 30, 0.1),
    }
