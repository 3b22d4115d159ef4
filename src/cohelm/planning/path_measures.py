"""Measures along a path: headings, gaps of the footprint to obstacles and zones, speed zones.

Gaps to obstacles are exact, from the outline to the squares of cells. Discs that cover the
footprint give a lower bound for each pose; poses are tested in the order of their bounds, so that
outline and squares are compared for few of them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import arc_length, inverse, resample, transform
from cohelm.kernels import CACHED, callee
from cohelm.maps import CostmapFilter, DistanceField
from cohelm.maps.masks import speed_limit_at
from cohelm.messages import Path, Wish
from cohelm.planning.costmap.layers.zones import distances_to_zone
from cohelm.planning.path_refinement.footprint import (
    FootprintModel,
    directions,
    footprint_model,
    gap_lower_bound,
    overlaps,
    turn_between,
)
from cohelm.robots import Robot

_LINE_SPACING = 0.05  # m
_OUTLINE_SPACING = 0.02  # m


def poses_along(path: Path, spacing: float) -> Floats:
    """Poses (m, 3) about ``spacing`` apart on a path, headed along it, or against it in reverse."""
    points, line = path.points, resample(path.points, spacing)
    along = arc_length(points)
    if along[-1] <= 0.0:
        return np.column_stack([line, np.zeros(len(line))])
    at = np.linspace(0.0, along[-1], len(line))
    segment = np.clip(np.searchsorted(along, at, side="right") - 1, 0, len(points) - 2)
    headings = directions(points) + np.pi * driven_backward(path)
    return np.column_stack([line, headings[segment]])


def driven_backward(path: Path) -> Booleans:
    """True (k - 1,) for the segments of a path that are driven backwards."""
    segments = np.arange(len(path.points) - 1)
    changes = np.searchsorted(path.cusps, segments, side="right")
    backward: Booleans = (changes + path.backs_out) % 2 == 1
    return backward


def min_gap(path: Path, robot: Robot, walls: DistanceField) -> float:
    """Minimum distance between the footprint driven along a path and blocked cells, m.

    Turns on the spot are included. 0 for an overlap; the field's diagonal if nothing blocks. Points
    must not repeat.
    """
    outline = robot.outline
    body = footprint_model(outline, walls.distance, walls.resolution)
    points = transform(inverse(walls.X_MG), path.points)
    poses = poses_driven(points, driven_backward(path), body.reach)
    return min(
        float(least_gap_of(body, outline, poses)),
        walls.resolution * math.hypot(*walls.distance.shape),
    )


def gap_to_zone(path: Path, robot: Robot, zone: Wish) -> float:
    """Minimum distance between the footprint along a path and an avoided zone, m.

    Negative inside the zone. Computed for points on the outline, so a zone with a sharp corner may
    be closer by a centimetre.
    """
    outline = robot.outline
    ring = resample(np.concatenate([outline, outline[:1]]), _OUTLINE_SPACING)
    body = np.concatenate([ring, np.zeros((1, 2))])
    placed = transform(poses_along(path, _LINE_SPACING)[:, None], body[None])
    return float(distances_to_zone(zone, placed.reshape(-1, 2)).min())


def time_in_speed_zones(
    points: Floats, filters: tuple[CostmapFilter, ...], speed: float, full_speed: float
) -> float:
    """Extra time by speed masks along a polyline (k, 2) that else is driven at ``speed``, s."""
    if not any(each.type != "keepout" for each in filters):
        return 0.0
    line = resample(points, _LINE_SPACING)
    steps = np.diff(arc_length(line))
    middles = (line[:-1] + line[1:]) / 2.0
    limits = np.array([speed_limit_at(filters, p, full_speed) for p in middles])
    return float((steps * (1.0 / np.minimum(limits, speed) - 1.0 / speed)).sum())


_POSE_SPACING = 0.025  # m between poses, and between those of the farthest corner in a turn


@njit(**CACHED)
def poses_driven(points: Floats, backward: Booleans, reach: float) -> Floats:
    """Poses (m, 3) on a polyline (n, 2), with each segment's heading and turns at its points.

    Args:
        points: m; they must not repeat.
        backward: segments (n - 1,) that are driven backwards.
        reach: distance to the farthest corner of the footprint, m.
    """
    heading = directions(points) + math.pi * backward
    poses = [np.array([points[0, 0], points[0, 1], heading[0] if len(heading) else 0.0])]
    for i in range(heading.shape[0]):
        if i > 0:
            turn = turn_between(heading[i - 1], heading[i])
            count = math.ceil(abs(turn) * reach / _POSE_SPACING)
            for k in range(1, count):
                angle = heading[i - 1] + turn * k / count
                poses.append(np.array([points[i, 0], points[i, 1], angle]))
        step = points[i + 1] - points[i]
        count = max(math.ceil(math.hypot(step[0], step[1]) / _POSE_SPACING), 1)
        for k in range(0 if i > 0 else 1, count + 1):
            at = points[i] + step * (k / count)
            poses.append(np.array([at[0], at[1], heading[i]]))
    out = np.empty((len(poses), 3))
    for i in range(len(poses)):
        out[i] = poses[i]
    return out


@njit(**CACHED)
def least_gap_of(body: FootprintModel, outline: Floats, poses: Floats) -> float:
    """Minimum distance from the outline (k, 2) at the poses (n, 3) to blocked cells, m.

    0 for an overlap; ∞ if nothing blocks.
    """
    bounds = np.empty(poses.shape[0])
    for i in range(poses.shape[0]):
        bounds[i] = gap_lower_bound(body, poses[i, 0], poses[i, 1], poses[i, 2])
    best = np.inf
    for i in np.argsort(bounds):
        if bounds[i] >= best or best == 0.0:
            break
        # Search no farther than the minimum so far, nor much farther than the bound.
        reach = bounds[i] + body.bound[2] + 2.0 * body.resolution
        best = min(best, _gap(body, outline, poses[i], min(best, max(reach, 0.0))))
        if best == np.inf:
            best = _gap(body, outline, poses[i], np.inf)
    return best


@callee()
def _gap(body: FootprintModel, outline: Floats, pose: Floats, most: float) -> float:
    """Distance from the outline at a pose to blocked cells; ∞ if it is ``most`` or more."""
    x, y, heading = pose
    if overlaps(body, x, y, heading):
        return 0.0
    cos, sin = math.cos(heading), math.sin(heading)
    corners = np.empty_like(outline)
    for k in range(outline.shape[0]):
        corners[k, 0] = x + cos * outline[k, 0] - sin * outline[k, 1]
        corners[k, 1] = y + sin * outline[k, 0] + cos * outline[k, 1]
    rows, cols = body.clearance.shape
    res = body.resolution
    best = most
    r = _cell(corners[:, 1].min() - best, res, rows)
    while r < rows and r * res <= corners[:, 1].max() + best:
        c = _cell(corners[:, 0].min() - best, res, cols)
        while c < cols and c * res <= corners[:, 0].max() + best:
            room = min(np.float64(body.clearance[r, c]), body.trust)
            if room < 0.0:
                best = min(best, _to_square(corners, c * res, r * res, res))
            c += max(1, int(room / res))
        r += 1
    return best if best < most else np.inf


@callee()
def _cell(x: float, resolution: float, count: int) -> int:
    """Index of the cell of a coordinate, or the nearest one."""
    return int(min(max(x / resolution, 0.0), float(count - 1)))


@callee()
def _to_square(corners: Floats, left: float, low: float, side: float) -> float:
    """Distance between a polygon (k, 2) and a square that it does not overlap."""
    best = np.inf
    n = corners.shape[0]
    for k in range(n):
        ax, ay = corners[k, 0], corners[k, 1]
        dx = max(left - ax, 0.0, ax - left - side)
        dy = max(low - ay, 0.0, ay - low - side)
        best = min(best, dx * dx + dy * dy)
        bx, by = corners[(k + 1) % n, 0] - ax, corners[(k + 1) % n, 1] - ay
        square = bx * bx + by * by
        for corner in range(4):
            px = left + side * (corner % 2) - ax
            py = low + side * (corner // 2) - ay
            t = min(max((px * bx + py * by) / square, 0.0), 1.0)
            best = min(best, (px - t * bx) ** 2 + (py - t * by) ** 2)
    return math.sqrt(best)
