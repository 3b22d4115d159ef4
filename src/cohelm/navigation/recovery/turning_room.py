"""Turning room: check that the footprint can turn on the spot."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import transform
from cohelm.maps import DistanceField
from cohelm.robots import Robot

_SPACING = 0.05
"""Maximum distance between two checked positions of a corner, m: a cell of usual maps."""


def can_turn(
    robot: Robot, pose: Floats, angle: float, walls: DistanceField, *, margin: float
) -> bool:
    """Check that the chair can turn on the spot by ``angle``, rad, or the other way round.

    Args:
        robot: its discs.
        pose: X_MR, (3,).
        angle: positive to the left.
        walls: distance to everything that is not a person.
        margin: minimum gap to walls, m; never more than the gap now, so that a chair close to a
            wall may turn away from it.
    """
    full = 2.0 * math.pi
    return any(
        _fits(robot, pose, each, walls, margin)
        for each in (angle, angle - math.copysign(full, angle))
    )


def _fits(robot: Robot, pose: Floats, angle: float, walls: DistanceField, margin: float) -> bool:
    count = 2 + math.ceil(abs(angle) * robot.circumscribed_radius / _SPACING)
    poses = np.tile(np.asarray(pose, dtype=float), (count, 1))
    poses[:, 2] += np.linspace(0.0, angle, count)
    discs = robot.discs
    gaps = walls.at(transform(poses[:, None], discs[None, :, :2])) - discs[:, 2]
    return bool((gaps >= np.minimum(margin, gaps[0])).all())
