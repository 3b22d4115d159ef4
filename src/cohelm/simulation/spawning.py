"""Pedestrians who enter a world during a ride."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.simulation.api import Crowd


@value
class NewPedestrian:
    """A pedestrian without a group, with w way-points."""

    position: Annotated[Floats, Shape("2")]
    """m."""
    waypoints: Annotated[Floats, Shape("w 2")]
    """In order, m; w = 0: standing."""
    heading: float = 0.0
    """Direction faced, rad."""
    speed: float = 1.2
    """Preferred speed, m/s."""
    radius: float = 0.25
    """Radius of the body, m."""
    stature: float = 1.7
    """Height, m."""
    loop: bool = False
    """Start again at the first way-point after the last."""
    sees_robot: bool = True
    """Avoid the robot."""


def with_pedestrian(crowd: Crowd, new: NewPedestrian) -> Crowd:
    """Append a pedestrian to the crowd; indices of the others stay.

    The model's private state of the new one is NaN: an inattentive person has not noticed the
    chair, a distracted one has not turned, and in a replayed film the new one follows the model of
    the scenario's other people.
    """
    n = len(crowd.radius)
    width = max(crowd.waypoints.shape[1], len(new.waypoints), 1)
    waypoints = np.full((n + 1, width, 2), np.nan)
    waypoints[:n, : crowd.waypoints.shape[1]] = crowd.waypoints
    waypoints[n, : len(new.waypoints)] = new.waypoints
    group, present, memory = crowd.group, crowd.present, crowd.memory
    return replace(
        crowd,
        position=np.vstack([crowd.position, new.position]),
        velocity=np.vstack([crowd.velocity, np.zeros(2)]),
        heading=np.append(crowd.heading, new.heading),
        radius=np.append(crowd.radius, new.radius),
        preferred_speed=np.append(crowd.preferred_speed, new.speed),
        waypoints=waypoints,
        target=np.append(crowd.target, np.int64(0)),
        loop=np.append(crowd.loop, np.bool_(new.loop)),
        sees_robot=np.append(crowd.sees_robot, np.bool_(new.sees_robot)),
        group=None if group is None else np.append(group, np.int64(-1)),
        present=None if present is None else np.append(present, np.True_),
        memory=None if memory is None else np.vstack([memory, np.full(memory.shape[1], np.nan)]),
    )
