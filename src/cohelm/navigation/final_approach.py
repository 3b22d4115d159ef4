"""Final approach: the last metre of a path, where the goal must be met and not overshot."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.geometry import arc_length, inverse, resample, transform
from cohelm.maps import DistanceField
from cohelm.messages import Path
from cohelm.navigation.tick import StepInput, Tick
from cohelm.robots import Robot

_LENGTH = 1.0
"""Remaining length at which the final approach begins, m."""
_OFFSET = 0.08
"""Distance beside the path from which the chair heads for the goal itself, m: two thirds of the
goal tolerance."""
_SPACING = 0.1
"""Spacing of the points of the straight line to the goal, m."""
_MARGIN = 0.02
"""Gap of the line's clearance beyond the inscribed radius, m."""
_FINAL_SPEED = 0.15
"""Speed up to which a chair may be at the end of its path, m/s: it brakes within 1 cm."""
_REACTION = 0.15
"""Time until the wheels follow a lower limit, s: a tick and the drive's lag, 0.13 s, rounded up."""
_AT_END = 0.02
"""Remaining length of a chair at the end of its path, m."""
_AHEAD = 0.5
"""Cosine of the bearing from which a goal is beside the chair: 60°."""
_BESIDE = 1.2
"""Tolerance of a slow chair beside its goal, as a multiple of the one with the goal ahead."""


def final_approach(
    path: Path, progress: float, position: Floats, walls: DistanceField, robot: Robot
) -> Path | None:
    """Straight line to the end of the path for a chair near its goal that is beside the path.

    Args:
        path: to the goal.
        progress: arc length of the chair's projection on it, m.
        position: of the chair (2,), m.
        walls: distance to everything that is not a person.
        robot: its inscribed radius.

    Returns:
        The line; None: follow the path, because it is far from the goal, near the path, or blocked.
    """
    goal = path.points[-1]
    if path.length - progress > _LENGTH or _offset(path, progress, position) <= _OFFSET:
        return None
    line = resample(np.stack([position, goal]), _SPACING)
    if (walls.at(line) < robot.inscribed_radius + _MARGIN).any():
        return None
    return _with_points(path, line)


def path_up_to(path: Path, length: float) -> Path:
    """Cut a path at an arc length, m."""
    along = arc_length(path.points)
    end = [np.interp(length, along, path.points[:, i]) for i in (0, 1)]
    return _with_points(path, np.vstack([path.points[along < length], end]))


def approach_limit(remaining: float, twist: Floats, deceleration: float) -> float:
    """Speed limit of a chair that would drive past its goal, m/s; +inf if it can brake in comfort.

    A reference that ends does not stop every planner: beyond its end nothing is lost, and a person
    behind the chair can make driving on the cheaper choice.

    Args:
        remaining: length of the path, m.
        twist: of the chair (3,).
        deceleration: comfort braking, m/s².
    """
    speed = float(np.hypot(*twist[:2]))
    braking = max(remaining - _REACTION * speed, 0.0)
    limit = float(np.sqrt(_FINAL_SPEED**2 + 2.0 * deceleration * braking))
    return limit if speed > limit or remaining <= _AT_END else float("inf")


def _offset(path: Path, progress: float, position: Floats) -> float:
    """Distance of the chair from its projection on the path, or from the goal at its end, m."""
    along = arc_length(path.points)
    at = [float(np.interp(progress, along, path.points[:, i])) for i in (0, 1)]
    return float(np.hypot(*(position - at)))


def _with_points(path: Path, points: Floats) -> Path:
    return replace(
        path,
        points=points,
        length=float(arc_length(points)[-1]),
        without_wishes=points,
        pivots=np.empty(0, dtype=np.int64),
    )


def has_arrived(step: StepInput, last: Tick | None) -> bool:
    """Check the distance to the goal, with hysteresis.

    The tolerance of a slow chair is larger, so that it does not turn for the last centimetres, and
    larger still with the goal aside or behind, where it would first have to turn on the spot.
    """
    setup, observation, request = step.setup, step.observation, step.request
    distance = float(np.hypot(*(request.goal - observation.pose[:2])))
    stays = last is not None and last.arrived and np.array_equal(last.request.goal, request.goal)
    slow = float(np.hypot(*observation.twist[:2])) < setup.goal_slow_speed
    if not stays and slow and last is not None:
        beside = transform(inverse(observation.pose), request.goal)[0] < _AHEAD * distance
        tolerance = setup.goal_slow_tolerance * (_BESIDE if beside else 1.0)
        return bool(distance <= max(tolerance, setup.goal_tolerance))
    return bool(distance <= setup.goal_tolerance * (2.0 if stays else 1.0))
