"""Choice of a path beside the desired one, by a driver who knows the size of the chair.

Paths beside the desired one are simulated at several speeds with the rider's own steering law and
the whole footprint, against visible obstacles and walking people; the one with the most progress is
chosen. This is a dynamic window (Fox, Burgard and Thrun 1997) over paths instead of twists: a
rollout can be an S, as through a gap beside the route.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.geometry import arc_length, inverse, nearest_on_polyline, transform
from cohelm.kernels import CACHED
from cohelm.simulation.api import RiderView
from cohelm.simulation.riders.rollouts import (
    COMFORT_GAPS,
    GEARS,
    SPACING,
    STEPS,
    TURNED,
    bearing,
    best_rollout,
)

_MAX_POINTS = 50
"""Number of points of the desired path that are considered."""
_OFFSETS = np.arange(-6, 7) * 0.2
"""Offsets of candidate paths to the left, m …"""
_SHIFTS = (0.0, 0.1, 0.05, -0.05)
"""… shifted by this amount in turn from call to call, m …"""
_REFINEMENTS = np.array([0.0, 0.03, -0.03])
"""… and offsets about the previous choice, m."""
_MEMORY_RADIUS = 2.0
"""Distance up to which obstacles out of sight are remembered, m."""
_MEMORY_TIME = 2.0
"""Time for which an obstacle is remembered that should be in sight and is not, s."""
_SAME = 0.07
"""Maximum distance of two observations of the same obstacle along each axis, m."""


@value
class RememberedObstacles:
    """Obstacles about the chair, in its frame: those in sight first, then those remembered."""

    points: Annotated[Floats, Shape("n 2")]
    """m."""
    time: Annotated[Floats, Shape("n")]
    """Time of the last sight, s."""


NO_OBSTACLES = RememberedObstacles(points=np.empty((0, 2)), time=np.empty(0))


@value
class SteeringLaw:
    """Steering law of the rider, and the expected response of the chair."""

    forward: float
    """Deflection on a straight path."""
    turn_gain: float
    """Lateral deflection per radian, 1/rad."""
    lookahead: float
    """m."""
    full: Annotated[Floats, Shape("2")]
    """Speed and turn rate at full deflection, m/s and rad/s."""


@value
class PathOffset:
    """A path beside the desired one, and its gear."""

    offset: float
    """To the left of the desired path, m."""
    gear: int
    """Row of ``GEARS``."""


def update_obstacles(
    view: RiderView, before: RememberedObstacles, motion: Floats
) -> RememberedObstacles:
    """Combine obstacles in sight with remembered ones.

    Args:
        view: of the rider.
        before: obstacles at the last call.
        motion: felt motion of the chair since then, (3,).
    """
    met = np.isfinite(view.free)
    bearings = view.bearings[met]
    now = view.free[met, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    old = transform(inverse(motion), before.points)
    field = float(np.abs(view.bearings).max(initial=0.0)) - 0.1
    kept = _is_remembered(now, old, view.time - before.time, field)
    return RememberedObstacles(
        points=np.concatenate([now, old[kept]]),
        time=np.concatenate([np.full(len(now), view.time), before.time[kept]]),
    )


@njit(**CACHED)
def _is_remembered(now: Floats, old: Floats, age: Floats, field: float) -> Booleans:
    """Mask of the old points (n, 2) that are near, not outdated and not in sight again."""
    kept = np.zeros(len(old), dtype=np.bool_)
    for i in range(len(old)):
        x, y = old[i]
        if x * x + y * y > _MEMORY_RADIUS * _MEMORY_RADIUS:
            continue
        if age[i] > _MEMORY_TIME and abs(math.atan2(y, x)) < field:
            continue
        kept[i] = True
        for j in range(len(now)):
            if abs(now[j, 0] - x) < _SAME and abs(now[j, 1] - y) < _SAME:
                kept[i] = False
                break
    return kept


def desired_path(view: RiderView) -> Floats:
    """Desired path ahead, ``SPACING`` apart, in the chair's frame, (m, 4).

    Points, and unit vectors to the left of the path; at least one, and the last is the end of the
    path or of the part that is considered.
    """
    route = view.route if len(view.route) > 1 else np.array([view.pose[:2], view.goal])
    route = transform(inverse(view.pose), route)
    s = arc_length(route)
    at, _ = nearest_on_polyline(route, 0.0, 0.0)
    count = min(math.ceil((s[-1] - at) / SPACING) + 1, _MAX_POINTS)
    middle = np.minimum(at + SPACING * np.arange(count), s[-1])
    samples = np.concatenate([middle, middle - SPACING, middle + SPACING])
    x, y = np.interp(samples, s, route[:, 0]), np.interp(samples, s, route[:, 1])
    dx, dy = x[2 * count :] - x[count : 2 * count], y[2 * count :] - y[count : 2 * count]
    length = np.maximum(np.hypot(dx, dy), 1e-9)
    return np.column_stack([x[:count], y[:count], -dy / length, dx / length])


def best_offset(
    view: RiderView,
    path: Floats,
    obstacles: RememberedObstacles,
    *,
    law: SteeringLaw,
    outline: Floats,
    previous: PathOffset | None,
    call: int,
) -> PathOffset | None:
    """Choose the path with the most progress; None if none is drivable.

    Args:
        view: of the rider.
        path: the desired one, (m, 4); see ``desired_path``.
        obstacles: about the chair.
        law: steering law.
        outline: of the chair, (k, 2), m.
        previous: last choice; of two equal paths the one nearer to it is taken.
        call: number of the call; the next one tries other offsets.
    """
    current = previous.offset if previous is not None else 0.0
    offsets = np.concatenate(
        [[0.0], current + _REFINEMENTS, _OFFSETS + _SHIFTS[call % len(_SHIFTS)]]
    )
    box = np.concatenate([outline.min(axis=0), outline.max(axis=0)])
    travel = law.forward * law.full[0] * STEPS * GEARS[0, 2]
    extent = travel + np.abs(box).max() + COMFORT_GAPS[0]
    near = obstacles.points[np.hypot(*obstacles.points.T) < extent]
    gains = np.array([law.forward, law.turn_gain, law.lookahead])
    gear, chosen = best_rollout(
        path, near, view.people, view.twist, box, gains, law.full, offsets, current
    )
    return PathOffset(offset=float(chosen), gear=int(gear)) if gear >= 0 else None


def steering_of(path: Floats, choice: PathOffset, lookahead: float) -> tuple[float, float]:
    """Bearing to steer for (rad, to the left), and share of the speed."""
    share, ahead, _, turns = GEARS[choice.gear]
    angle = float(bearing(path, np.zeros(3), 0, choice.offset, lookahead * ahead))
    return angle, float(share * (turns == 0.0 or abs(angle) <= TURNED))
