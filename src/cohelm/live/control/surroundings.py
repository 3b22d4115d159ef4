"""Free distance about the chair and people in view, from the newest planar scans.

The direction ring of the page shows what the scanners measure now, whatever the map says.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import transform
from cohelm.messages import Observation, Scan

DIRECTIONS = 36
"""Number of directions of the ring."""
SHOWN_RANGE = 4.0
"""Maximum free distance that is told, m."""
NOT_SEEN = -1.0
"""Value of a direction that no scanner covers."""
BODY = 0.35
"""Maximum distance of a return from the middle of a person who is in view, m; assumed."""
Corners = tuple[tuple[float, float], ...]


def free_distances(observation: Observation, outline: Corners) -> tuple[float, ...]:
    """Return the free distance from the outline in each direction, from ahead counter-clockwise.

    Args:
        observation: Newest observation.
        outline: Corners of the chair in its own frame, m.

    Returns:
        ``DIRECTIONS`` distances, m, at most ``SHOWN_RANGE``; ``NOT_SEEN`` where no beam points;
        empty without a planar scanner.
    """
    if not observation.scans:
        return ()
    nearest = np.full(DIRECTIONS, np.inf)
    for scan in observation.scans:
        points = _ends(scan)
        sector = np.round(np.arctan2(points[:, 1], points[:, 0]) * (DIRECTIONS / (2.0 * np.pi)))
        np.minimum.at(
            nearest, sector.astype(np.int64) % DIRECTIONS, np.hypot(points[:, 0], points[:, 1])
        )
    covered = np.isfinite(nearest)
    free = np.clip(nearest - _extents(outline), 0.0, SHOWN_RANGE)
    return tuple(np.where(covered, free, NOT_SEEN).round(2).tolist())


def in_view(observation: Observation, points: Floats) -> tuple[bool, ...]:
    """Check which points (n, 2) of the map have a return of a scanner close to them.

    Without a planar scanner all count as seen.
    """
    if not observation.scans or not len(points):
        return (True,) * len(points)
    X_MR = observation.pose
    returns = np.concatenate([transform(X_MR, _returns(scan)) for scan in observation.scans])
    if not len(returns):
        return (False,) * len(points)
    dx, dy = (points[:, None, axis] - returns[None, :, axis] for axis in (0, 1))
    return tuple(((dx * dx + dy * dy).min(axis=1) < BODY**2).tolist())


def _beams(scan: Scan) -> Floats:
    return scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges), dtype=np.float64)


def _ends(scan: Scan) -> Floats:
    """Ends of all beams (k, 2) in the robot's frame; a beam without a return ends at its range."""
    ranges = np.where(np.isinf(scan.ranges), scan.range_max, scan.ranges)
    valid = np.isfinite(ranges)
    angles, ranges = _beams(scan)[valid], ranges[valid]
    return _in_robot_frame(scan, angles, ranges)


def _returns(scan: Scan) -> Floats:
    """Returns (k, 2) in the robot's frame."""
    valid = np.isfinite(scan.ranges)
    angles, ranges = _beams(scan)[valid], scan.ranges[valid]
    return _in_robot_frame(scan, angles, ranges)


def _in_robot_frame(scan: Scan, angles: Floats, ranges: Floats) -> Floats:
    ends = np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles)])
    return transform(scan.mount, ends)


@functools.cache
def _extents(outline: Corners) -> Floats:
    """Distance (DIRECTIONS,) from the origin to the outline in each direction, m."""
    corners = np.array(outline)
    edges = np.roll(corners, -1, axis=0) - corners
    found = np.zeros(DIRECTIONS)
    for k in range(DIRECTIONS):
        angle = 2.0 * math.pi * k / DIRECTIONS
        ray = np.array([math.cos(angle), math.sin(angle)])
        # corner + s · edge = t · ray, solved for each edge by Cramer's rule.
        across = ray[0] * edges[:, 1] - ray[1] * edges[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (corners[:, 0] * edges[:, 1] - corners[:, 1] * edges[:, 0]) / across
            s = (corners[:, 0] * ray[1] - corners[:, 1] * ray[0]) / across
        hit = np.isfinite(t) & (t > 0.0) & (s >= 0.0) & (s <= 1.0)
        found[k] = t[hit].max(initial=0.0)
    return found
