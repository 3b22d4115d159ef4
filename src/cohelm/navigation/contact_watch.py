"""Time of the last contact: the chair stands for a moment after a person has walked into it."""

from __future__ import annotations

import numpy as np

from cohelm.messages import Observation, People
from cohelm.robots import Robot
from cohelm.robots.contact import touching
from cohelm.robots.contact_kernel import WALKING

_HIDDEN = -0.1
"""Gap of a person who is about to be hidden within the footprint, m."""
_PASSES = 2.0
"""Time in which such a person comes out again, s."""


def update_last_contact(
    before: float, robot: Robot, observation: Observation, people: People
) -> float:
    """Time when a walking person last touches the chair, s; ``before`` if nobody does now.

    A person behind a chair that drives on does not count. A person who overlaps the footprint is
    hidden from the sensors until they have passed, so their contact is expected to last.
    """
    pose, time = observation.pose, observation.time
    walks = np.hypot(people.mean[:, 2], people.mean[:, 3]) > WALKING
    ahead = np.array([np.cos(pose[2]), np.sin(pose[2])])
    behind = (people.mean[:, :2] - pose[:2]) @ ahead < robot.outline[:, 0].min()
    leaves = observation.twist[0] > WALKING
    counts = walks & ~(behind & leaves)
    if (touching(robot, pose, people, gap=_HIDDEN) & counts).any():
        return time + _PASSES
    if (touching(robot, pose, people) & counts).any():
        return max(time, before)
    return before
