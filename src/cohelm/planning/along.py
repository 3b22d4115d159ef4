"""Along a path: headings, how near the footprint comes to what stands there, speed zones."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import arc_length, inverse, resample, transform
from cohelm.maps import CostmapFilter, DistanceField
from cohelm.maps.masks import speed_limit_at
from cohelm.messages import Wish
from cohelm.planning.footprint import body_on
from cohelm.planning.gaps import least_gap_of, poses_driven
from cohelm.planning.layers.zones import distances_to_zone
from cohelm.robots import Robot

_SPACING = 0.05  # m
_OUTLINE_SPACING = 0.02  # m


def poses_along(points: Floats, spacing: float) -> Floats:
    """Poses (m, 3) about ``spacing`` apart on a polyline (k, 2), headed along it."""
    line = resample(points, spacing)
    if len(line) < 2 or arc_length(line)[-1] <= 0.0:
        return np.column_stack([line, np.zeros(len(line))])
    step = np.gradient(line, axis=0)
    return np.column_stack([line, np.arctan2(step[:, 1], step[:, 0])])


def least_gap(points: Floats, robot: Robot, walls: DistanceField) -> float:
    """Least distance between the footprint driven along a polyline (k, 2) and blocked cells, m.

    From outline to square, turns on the spot included; 0 where they overlap, the field's diagonal
    where nothing stands. Points do not repeat.
    """
    outline = robot.outline
    body = body_on(outline, walls.distance, walls.resolution)
    poses = poses_driven(transform(inverse(walls.X_MG), points), body.reach)
    return min(
        float(least_gap_of(body, outline, poses)),
        walls.resolution * math.hypot(*walls.distance.shape),
    )


def gap_to_zone(points: Floats, robot: Robot, zone: Wish) -> float:
    """Least distance between the footprint along a polyline (k, 2) and an avoided zone, m.

    Negative: as deep as the outline comes into it. Of points on the outline, so a zone with a sharp
    corner may be nearer by a centimetre.
    """
    outline = robot.outline
    ring = resample(np.concatenate([outline, outline[:1]]), _OUTLINE_SPACING)
    body = np.concatenate([ring, np.zeros((1, 2))])
    placed = transform(poses_along(points, _SPACING)[:, None], body[None])
    return float(distances_to_zone(zone, placed.reshape(-1, 2)).min())


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
