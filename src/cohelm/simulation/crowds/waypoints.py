"""Where a pedestrian wants to go next."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers

_PASSED = 0.5
"""A way-point counts as reached within this distance, m."""
_ARRIVED = 0.2
"""The last one within this, m."""
_SLOWING = 1.0
"""Time constant of the approach to the last way-point, s; CrowdNav's."""


@njit(cache=True)
def advance_targets(
    position: Floats, waypoints: Floats, target: Integers, loop: Booleans
) -> Integers:
    """The index (n,) of the way-point each is walking to after those reached by now.

    Args:
        position: (n, 2).
        waypoints: (n, w, 2), NaN beyond a person's last.
        target: (n,), the number of way-points when done.
        loop: (n,), whether the first follows on the last.
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


@njit(cache=True)
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
        wanted = min(speed[i], distance / _SLOWING) if last else speed[i]
        out[i, 0], out[i, 1] = wanted * dx / distance, wanted * dy / distance
    return out


@njit(cache=True)
def current_targets(waypoints: Floats, target: Integers) -> Floats:
    """The way-point (n, 2) each is walking to; NaN when done."""
    out = np.full((target.shape[0], 2), np.nan)
    for i in range(target.shape[0]):
        if target[i] < waypoint_count(waypoints, i):
            out[i] = waypoints[i, target[i]]
    return out


@njit(cache=True)
def last_passed(waypoints: Floats, target: Integers, loop: Booleans) -> Floats:
    """The way-point (n, 2) before the one each is walking to; NaN where there is none."""
    out = np.full((target.shape[0], 2), np.nan)
    for i in range(target.shape[0]):
        count = waypoint_count(waypoints, i)
        if 0 < target[i] < count:
            out[i] = waypoints[i, target[i] - 1]
        elif target[i] == 0 and loop[i] and count > 1:
            out[i] = waypoints[i, count - 1]
    return out


@njit(cache=True)
def waypoint_count(waypoints: Floats, i: int) -> int:
    """How many way-points person ``i`` has."""
    count = 0
    while count < waypoints.shape[1] and not math.isnan(waypoints[i, count, 0]):
        count += 1
    return count


@njit(cache=True)
def last_of(waypoints: Floats, target: Integers) -> Floats:
    """The last way-point (n, 2) of those who are done; NaN for the others."""
    out = np.full((target.shape[0], 2), np.nan)
    for i in range(target.shape[0]):
        count = waypoint_count(waypoints, i)
        if 0 < count <= target[i]:
            out[i] = waypoints[i, count - 1]
    return out
