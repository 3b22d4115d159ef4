"""Turning room: check that the footprint can turn on the spot."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import transform
from cohelm.maps import DistanceField
from cohelm.robots.robot import Robot

BEHIND = math.radians(75.0)
"""Turn from the heading to a path above which the path begins behind the chair, rad."""
TURNING_MARGIN = 0.02
"""Gap to walls while turning, m: that of the planner's verification."""
_EITHER_WAY = math.radians(150.0)
"""Turn from which a local planner may turn the longer way; below, it turns the shorter one only."""
_SPACING = 0.05
"""Maximum distance between two checked positions of a corner, m: a cell of usual maps."""


def must_turn_elsewhere(
    robot: Robot, pose: Floats, turn: float, walls: DistanceField, margin: float = TURNING_MARGIN
) -> bool:
    """Check for a path that begins behind a chair that cannot turn to it where it is.

    ``turn`` is the angle from the heading to the path, rad; the rest is as in :func:`can_turn`.
    """
    return abs(turn) > BEHIND and not can_turn(robot, pose, turn, walls, margin=margin)


def can_turn(
    robot: Robot, pose: Floats, angle: float, walls: DistanceField, *, margin: float
) -> bool:
    """Check that the chair can turn on the spot by ``angle``, rad.

    Args:
        robot: its discs.
        pose: X_MR, (3,).
        angle: positive to the left; about half a turn may be made either way.
        walls: distance to everything that is not a person.
        margin: minimum gap to walls, m; never more than the gap now, so that a chair close to a
            wall may turn away from it.
    """
    angles = [angle]
    if abs(angle) >= _EITHER_WAY:
        angles.append(angle - math.copysign(2.0 * math.pi, angle))
    return any(_fits(robot, pose, each, walls, margin) for each in angles)


def _fits(robot: Robot, pose: Floats, angle: float, walls: DistanceField, margin: float) -> bool:
    count = 2 + math.ceil(abs(angle) * robot.circumscribed_radius / _SPACING)
    poses = np.tile(np.asarray(pose, dtype=float), (count, 1))
    poses[:, 2] += np.linspace(0.0, angle, count)
    discs = robot.discs
    gaps = walls.at(transform(poses[:, None], discs[None, :, :2])) - discs[:, 2]
    return bool((gaps >= np.minimum(margin, gaps[0])).all())
