"""Motion of pedestrians between way-points and from step to step."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.geometry import wrap_angle
from cohelm.kernels import CACHED, callee
from cohelm.simulation.api import Crowd

GOLDEN_RATIO = 0.6180339887498949
"""Fraction of the golden ratio: its multiples spread over 0 to 1 and never coincide."""
_WALKING = 0.1
"""Speed above which a person turns to the direction of motion, m/s."""
_FAR, _SPACING = 1e6, 10.0
"""Position of absent people, and their distance from each other, m."""
_PASSED = 0.5
"""Distance at which a way-point is reached, m."""
_ARRIVED = 0.2
"""Distance at which the last one is reached, m."""
_SLOWING = 1.0
"""Time constant of the approach to the last way-point, s; as in CrowdNav."""


def displacement(before: Crowd, after: Crowd) -> Floats:
    """Displacement (n, 2) of people from one crowd to the next, m; 0 for those absent in one."""
    there = before.there & after.there
    return np.where(there[:, None], after.position - before.position, 0.0)


def interpolated(before: Crowd, after: Crowd, share: float) -> Floats:
    """Positions (n, 2) of people, a share of the step after ``before``, m."""
    return before.position + share * displacement(before, after)


def far_away(count: int) -> Floats:
    """Positions (count, 2) for absent people: beyond every map and apart from each other, m."""
    return np.column_stack([_FAR + _SPACING * np.arange(count), np.full(count, _FAR)])


def turned_towards(heading: Floats, velocity: Floats, dt: float, turn_time: float) -> Floats:
    """Headings (n,) after turning to the direction of motion for ``dt``; standing people keep it.

    Args:
        heading: (n,) before, rad.
        velocity: (n, 2), m/s.
        dt: s.
        turn_time: time constant, s.
    """
    walks: Booleans = np.hypot(velocity[:, 0], velocity[:, 1]) > _WALKING
    turn = wrap_angle(np.arctan2(velocity[:, 1], velocity[:, 0]) - heading)
    turned = heading + np.where(walks, turn * (1.0 - math.exp(-dt / turn_time)), 0.0)
    return np.asarray(wrap_angle(turned))


@njit(**CACHED)
def advance_targets(
    position: Floats, waypoints: Floats, target: Integers, loop: Booleans
) -> Integers:
    """Index (n,) of each person's current way-point after those reached by now.

    Args:
        position: (n, 2).
        waypoints: (n, w, 2), NaN beyond a person's last.
        target: (n,), the number of way-points when done.
        loop: (n,), True where the first follows the last.
    """
    out = target.copy()
    for i in range(position.shape[0]):
        count = waypoint_count(waypoints, i)
        if out[i] >= count:
            continue
        last = out[i] == count - 1 and not loop[i]
        dx = waypoints[i, out[i], 0] - position[i, 0]
        dy = waypoints[i, out[i], 1] - position[i, 1]
        if math.hypot(dx, dy) <= (_ARRIVED if last else _PASSED):
            out[i] = (out[i] + 1) % count if loop[i] else out[i] + 1
    return out


@njit(**CACHED)
def towards_targets(
    position: Floats, waypoints: Floats, target: Integers, loop: Booleans, speed: Floats
) -> Floats:
    """Preferred velocities (n, 2): straight to the way-point, slowing for the last; 0 when done."""
    out = np.zeros((position.shape[0], 2))
    for i in range(position.shape[0]):
        count = waypoint_count(waypoints, i)
        if target[i] >= count:
            continue
        dx = waypoints[i, target[i], 0] - position[i, 0]
        dy = waypoints[i, target[i], 1] - position[i, 1]
        distance = math.hypot(dx, dy)
        if distance == 0.0:
            continue
        last = target[i] == count - 1 and not loop[i]
        preferred = min(speed[i], distance / _SLOWING) if last else speed[i]
        out[i, 0], out[i, 1] = preferred * dx / distance, preferred * dy / distance
    return out


@njit(**CACHED)
def current_targets(waypoints: Floats, target: Integers) -> Floats:
    """Current way-point (n, 2) of each person; NaN when done."""
    out = np.full((target.shape[0], 2), np.nan)
    for i in range(target.shape[0]):
        if target[i] < waypoint_count(waypoints, i):
            out[i] = waypoints[i, target[i]]
    return out


@njit(**CACHED)
def last_passed(waypoints: Floats, target: Integers, loop: Booleans) -> Floats:
    """Way-point (n, 2) before the current one; NaN where there is none."""
    out = np.full((target.shape[0], 2), np.nan)
    for i in range(target.shape[0]):
        count = waypoint_count(waypoints, i)
        if 0 < target[i] < count:
            out[i] = waypoints[i, target[i] - 1]
        elif target[i] == 0 and loop[i] and count > 1:
            out[i] = waypoints[i, count - 1]
    return out


@callee()
def waypoint_count(waypoints: Floats, i: int) -> int:
    """Count the way-points of person ``i``."""
    count = 0
    while count < waypoints.shape[1] and not math.isnan(waypoints[i, count, 0]):
        count += 1
    return count


@njit(**CACHED)
def last_of(waypoints: Floats, target: Integers) -> Floats:
    """Last way-point (n, 2) of people who are done; NaN for the others."""
    out = np.full((target.shape[0], 2), np.nan)
    for i in range(target.shape[0]):
        count = waypoint_count(waypoints, i)
        if 0 < count <= target[i]:
            out[i] = waypoints[i, count - 1]
    return out


@njit(**CACHED)
def opposite_targets(waypoints: Floats, target: Integers) -> Integers:
    """Index (n,) of a person's way-point after turning back; −1 unless the route is a round trip.

    A round trip has an even number m of way-points, and the way back mirrors the way out: way-point
    m − j lies at way-point j.
    """
    out = np.full(target.shape[0], -1, dtype=np.int64)
    for i in range(target.shape[0]):
        count = waypoint_count(waypoints, i)
        if count < 2 or target[i] >= count:
            continue
        mirrored = True
        for j in range(1, count):
            apart = waypoints[i, j] - waypoints[i, count - j]
            mirrored = mirrored and apart[0] == 0.0 and apart[1] == 0.0
        if mirrored:
            out[i] = (count - target[i] + 1) % count
    return out
