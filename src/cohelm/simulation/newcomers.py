"""Who comes into a world that goes on already."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.simulation.api import Crowd


@value
class Newcomer:
    """Somebody who comes in, by w way-points; alone, of no group."""

    position: Annotated[Floats, Shape("2")]
    """Where they appear, m."""
    waypoints: Annotated[Floats, Shape("w 2")]
    """Where they walk, in order, m; w = 0: they stand."""
    heading: float = 0.0
    """Direction faced, rad."""
    speed: float = 1.2
    """At which they like to walk, m/s."""
    radius: float = 0.25
    """Of the body, m."""
    stature: float = 1.7
    """Height, m."""
    loop: bool = False
    """Starts again at the first way-point after the last."""
    sees_robot: bool = True
    """Avoids the robot."""


def joined(crowd: Crowd, newcomer: Newcomer) -> Crowd:
    """The crowd with one more, behind all others, whose numbers stay.

    A model's own record of who comes later is NaN: of inattentive people, that they have noticed
    nothing; of distracted ones, that they have not turned; of a replayed film, that they are not in
    it, and so they walk by the model of the scenario's other people.
    """
    n = len(crowd.radius)
    width = max(crowd.waypoints.shape[1], len(newcomer.waypoints), 1)
    waypoints = np.full((n + 1, width, 2), np.nan)
    waypoints[:n, : crowd.waypoints.shape[1]] = crowd.waypoints
    waypoints[n, : len(newcomer.waypoints)] = newcomer.waypoints
    memory = crowd.memory
    return replace(
        crowd,
        position=np.vstack([crowd.position, newcomer.position]),
        velocity=np.vstack([crowd.velocity, np.zeros(2)]),
        heading=np.append(crowd.heading, newcomer.heading),
        radius=np.append(crowd.radius, newcomer.radius),
        preferred_speed=np.append(crowd.preferred_speed, newcomer.speed),
        waypoints=waypoints,
        target=_longer(crowd.target, 0),
        loop=_or_not(crowd.loop, yes=newcomer.loop),
        sees_robot=_or_not(crowd.sees_robot, yes=newcomer.sees_robot),
        group=None if crowd.group is None else _longer(crowd.group, -1),
        present=None if crowd.present is None else _or_not(crowd.present, yes=True),
        memory=None if memory is None else np.vstack([memory, np.full(memory.shape[1], np.nan)]),
    )


def _longer(numbers: Integers, last: int) -> Integers:
    return np.append(numbers, np.int64(last))


def _or_not(answers: Booleans, *, yes: bool) -> Booleans:
    return np.append(answers, np.bool_(yes))
