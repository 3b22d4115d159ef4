"""Along a path: headings, how near the footprint comes to what stands there, speed zones."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import arc_length, resample, transform
from cohelm.maps import CostmapFilter, DistanceField
from cohelm.maps.masks import speed_limit_at
from cohelm.robots import Robot

_SPACING = 0.05  # m


def poses_along(points: Floats, spacing: float) -> Floats:
    """Poses (m, 3) about ``spacing`` apart on a polyline (k, 2), headed along it."""
    line = resample(points, spacing)
    if len(line) < 2 or arc_length(line)[-1] <= 0.0:
        return np.column_stack([line, np.zeros(len(line))])
    step = np.gradient(line, axis=0)
    return np.column_stack([line, np.arctan2(step[:, 1], step[:, 0])])


def least_gap(points: Floats, robot: Robot, walls: DistanceField) -> float:
    """Least distance between the footprint along a polyline (k, 2) and what stands there, m.

    The footprint is ``Robot.discs``, which contain it: the gap is not overstated.
    """
    poses, discs = poses_along(points, _SPACING), robot.discs
    centres = transform(poses[:, None], discs[None, :, :2])
    return float((walls.at(centres) - discs[:, 2]).min())


def time_in_speed_zones(
    points: Floats, filters: tuple[CostmapFilter, ...], speed: float, full_speed: float
) -> float:
    """Time that speed masks cost along a polyline (k, 2) that else is driven at ``speed``, s."""
    if not any(each.type != "keepout" for each in filters):
        return 0.0
    line = resample(points, _SPACING)
    steps = np.diff(arc_length(line))
    middles = (line[:-1] + line[1:]) / 2.0
    limits = np.array([speed_limit_at(filters, p, full_speed) for p in middles])
    return float((steps * (1.0 / np.minimum(limits, speed) - 1.0 / speed)).sum())
