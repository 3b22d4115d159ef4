"""Waiting before a narrow passage for people who come through it the other way.

A chair that stands in front of a door leaves nobody out, and nobody who stands in it lets the chair
in: neither can pass, and a switch cannot lead the chair out of that. So a chair that is led to a
narrow passage stops where a person can come out beside it, as long as that person would reach the
passage before the chair is through.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.geometry import wrap_angle
from cohelm.maps import DistanceField
from cohelm.messages import Observation
from cohelm.robots import Robot
from cohelm.sharing.affordances import NarrowPassage

STAND_OFF = 1.0
"""Distance of the chair's front from the middle of a passage at which it waits, m: a person and
their distance from chair and wall (assumed)."""
_REACH = 4.0
"""Distance from the passage up to which people count, m."""
_TOWARDS = 0.4
"""Share of a person's speed that leads to the passage: people walk round what is before it."""
_MARGIN = 0.5
"""Time that the chair must be through before a person arrives, s."""
_HOLD = 5.0
"""Time for which the chair goes on waiting for a person it has seen, s: they stop and turn …"""
_PATIENCE = 15.0
"""… and the time while a person is in the passage, where they squeeze through or stand, s."""
_ABOUT = math.pi / 4.0
"""Angle to a passage up to which the chair still goes there, rad."""
_WITHIN = 0.8
"""Distance from its middle up to which a person is in the passage, m."""
_DELAY = 0.3
"""Time until a chair that is to stop slows down, s."""
_SLOWEST = 0.1
"""Speed that a chair on its way through reaches at least, m/s."""


@value
class Surroundings:
    """Things and people about the chair."""

    walls: DistanceField
    """Of map and live obstacles."""
    standing: Annotated[Floats, Shape("n 3")]
    """People who stand, as x, y and radius, m."""
    walking: Annotated[Floats, Shape("k 4")]
    """People who walk, as x, y and velocity, m and m/s."""


class PassageWait(NamedTuple):
    """Memory of a person who comes through a passage."""

    passage: NarrowPassage
    """Passage that the chair was led to, also while people in it hide its far side."""
    seen: float
    """Time at which they were last seen coming, s."""
    stands: bool
    """The chair is where it leaves them room."""


def waits_before(
    observation: Observation,
    asked: float,
    passage: NarrowPassage | None,
    surroundings: Surroundings | None,
    robot: Robot,
    memory: PassageWait | None,
) -> PassageWait | None:
    """Check that the chair waits before a passage for a person who comes through it.

    Args:
        observation: time, pose and twist of the chair.
        asked: speed that the rider asks for, m/s.
        passage: that the chair is led to; None: no narrow one is detected.
        surroundings: people who walk and who stand; None: no people.
        robot: with its outline and brakes.
        memory: result of the last call, None at first.

    Returns:
        What to remember; None: nobody comes.
    """
    now, pose, speed = observation.time, observation.pose, max(float(observation.twist[0]), 0.0)
    if memory is not None and _faces(pose, memory.passage):
        passage = memory.passage
    if passage is None or surroundings is None:
        return None
    cos, sin = math.cos(passage.axis), math.sin(passage.axis)
    before = -(cos * (pose[0] - passage.x) + sin * (pose[1] - passage.y))
    front = before - float(robot.outline[:, 0].max())
    if front < 0.0:  # it is in the passage already
        return None
    through = (before - float(robot.outline[:, 0].min())) / max(asked, _SLOWEST)
    if _arrives(passage, surroundings.walking) < through + _MARGIN:
        seen = now
    elif memory is None:
        return None
    else:
        seen = memory.seen
    patience = _PATIENCE if _is_occupied(passage, surroundings) else _HOLD
    braking = speed * _DELAY + speed * speed / (2.0 * robot.max_deceleration)
    if now - seen >= patience:
        return None
    return PassageWait(passage, seen, stands=front < STAND_OFF + braking)


def _faces(pose: Floats, passage: NarrowPassage) -> bool:
    """Check that a chair still goes about towards a passage."""
    bearing = math.atan2(passage.y - pose[1], passage.x - pose[0])
    return abs(float(wrap_angle(bearing - pose[2]))) < _ABOUT


def _is_occupied(passage: NarrowPassage, surroundings: Surroundings) -> bool:
    """Check that a person is in the passage."""
    people = np.vstack([surroundings.walking[:, :2], surroundings.standing[:, :2]])
    apart = people - np.array([passage.x, passage.y])
    return bool((np.hypot(*apart.T) < _WITHIN).any())


def _arrives(passage: NarrowPassage, walking: Floats) -> float:
    """Time after which the first person who comes the other way is in the passage, s."""
    offset = np.array([passage.x, passage.y]) - walking[:, :2]
    distance, pace = np.hypot(*offset.T), np.hypot(*walking[:, 2:].T)
    beyond = -(offset @ np.array([math.cos(passage.axis), math.sin(passage.axis)]))
    closing = (offset * walking[:, 2:]).sum(axis=1) / np.maximum(distance, 1e-9)
    comes = (beyond > 0.0) & (distance < _REACH) & (closing > _TOWARDS * pace)
    times = np.where(comes, distance / np.maximum(pace, 1e-9), math.inf)
    return float(times.min(initial=math.inf))
