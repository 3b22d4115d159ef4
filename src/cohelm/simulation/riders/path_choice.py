"""Choice of a path beside the desired one, by a driver who knows the size of the chair.

Paths beside the desired one are simulated at several speeds with the rider's own steering law and
the whole footprint, against visible obstacles and walking people; the one with the most progress is
chosen. This is a dynamic window (Fox, Burgard and Thrun 1997) over paths instead of twists: a
rollout can be an S, as through a gap beside the route.

Each rollout follows the steering law for some seconds. The bounding box of the chair is checked
against obstacles in sight, and against people who walk on at constant velocity.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.geometry import arc_length, inverse, nearest_on_polyline, transform
from cohelm.kernels import CACHED, callee
from cohelm.simulation.api import RiderView

SPACING = 0.1
"""Spacing of the desired path, m."""
STEPS = 24
"""Steps of a rollout."""
GEARS = np.array(
    [
        # speed share, lookahead share, time step (s), turns first
        [1.0, 1.0, 0.18, 0.0],
        [0.5, 0.7, 0.25, 0.0],
        [0.25, 0.5, 0.30, 0.0],
        [0.25, 0.5, 0.30, 1.0],
    ]
)
"""Gears of a rollout: shares of the forward deflection and of the lookahead, time step, and 1 where
the chair first turns towards the path on the spot."""
TURNED = 0.2
"""Bearing below which the chair drives on in the last gear, rad."""

_REACTION = 0.4
"""Reaction time before braking, s."""
_RISES, _FALLS, _TURNS = 0.8, 1.0, 2.5
"""Assumed acceleration and deceleration, m/s², and angular acceleration, rad/s²."""
_MIN_GAPS = (0.03, 0.10)
"""Minimum gaps to an obstacle and to a person, m."""
COMFORT_GAPS = (0.2, 0.45)
"""Gaps below which discomfort costs, m …"""
_DISCOMFORT = (2.0, 1.5)
"""… at most this, if the chair drives at full speed all the time, m of progress."""
_HORIZON = 3.0
"""Time for which people are assumed to walk on, s."""
_BLOCKED = 1.0
"""Cost of an immediate contact, m of progress; less for a later one."""
_OFFSET_COST = 0.3
"""Cost of a metre of distance from the desired path, m of progress."""
_SWITCH_COST = 0.2
"""Cost of a metre of distance from the current offset, m of progress."""
_GOOD = 0.3
"""Cost below which slower gears are not tried, m."""
_MIN_PROGRESS = 0.05
"""Minimum progress of a usable rollout, m."""
_END_TOLERANCE = 0.15
"""Distance from its end at which a path is complete, m."""
_END_ZONE = 0.5
"""Distance from the end of the path within which offsets fade and progress is the distance to the
end, m."""


@njit(**CACHED)
def bearing(path: Floats, pose: Floats, at: int, offset: float, lookahead: float) -> float:
    """Bearing of the point to steer for, rad to the left.

    Args:
        path: (m, 4) as (x, y, and the unit vector to its left), ``SPACING`` apart, m.
        pose: of the chair, (3,).
        at: index of the path point at the chair.
        offset: to the left of the path, m.
        lookahead: along the path, m.
    """
    k = min(at + round(lookahead / SPACING), len(path) - 1)
    offset *= min((len(path) - 1 - k) * SPACING / _END_ZONE, 1.0)
    dx = path[k, 0] + offset * path[k, 2] - pose[0]
    dy = path[k, 1] + offset * path[k, 3] - pose[1]
    return float((math.atan2(dy, dx) - pose[2] + math.pi) % (2.0 * math.pi) - math.pi)


@callee()
def _gap(box: Floats, x: float, y: float) -> float:
    """Distance from a box (x, y low, x, y high) to a point; negative inside."""
    ex, ey = max(box[0] - x, x - box[2]), max(box[1] - y, y - box[3])
    if ex > 0.0 and ey > 0.0:
        return math.sqrt(ex * ex + ey * ey)
    return float(max(ex, ey))


@callee()
def _gaps(
    points: Floats, people: Floats, box: Floats, pose: Floats, time: float
) -> tuple[float, float]:
    """Gaps to the nearest obstacle and person, m; at most ``COMFORT_GAPS``."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    obstacle, person = COMFORT_GAPS
    for i in range(len(points)):
        dx, dy = points[i, 0] - pose[0], points[i, 1] - pose[1]
        ahead = c * dx + s * dy
        if box[0] - obstacle < ahead < box[2] + obstacle:
            obstacle = min(obstacle, _gap(box, ahead, c * dy - s * dx))
    if time <= _HORIZON:
        for i in range(len(people)):
            dx = people[i, 0] + time * people[i, 2] - pose[0]
            dy = people[i, 1] + time * people[i, 3] - pose[1]
            person = min(person, _gap(box, c * dx + s * dy, c * dy - s * dx) - people[i, 4])
    return obstacle, person


@callee()
def _next_index(path: Floats, pose: Floats, at: int) -> int:
    """Index of the path point at the chair, which was ``at`` before."""
    while at < len(path) - 1:
        dx, dy = path[at + 1, 0] - path[at, 0], path[at + 1, 1] - path[at, 1]
        along = (pose[0] - path[at, 0]) * dx + (pose[1] - path[at, 1]) * dy
        if along < 0.5 * (dx * dx + dy * dy):
            break
        at += 1
    return at


@callee()
def _progress(path: Floats, pose: Floats, at: int) -> tuple[float, float]:
    """Progress along the path, and distance from it, of a chair at its point ``at``, m."""
    end = len(path) - 1
    if (end - at) * SPACING < _END_ZONE:
        left = math.hypot(path[end, 0] - pose[0], path[end, 1] - pose[1])
        return end * SPACING - left, 0.0
    dx, dy = pose[0] - path[at, 0], pose[1] - path[at, 1]
    return at * SPACING + dx * path[at, 3] - dy * path[at, 2], abs(
        dx * path[at, 2] + dy * path[at, 3]
    )


@callee()
def _rollout(
    path: Floats,
    points: Floats,
    people: Floats,
    twist: Floats,
    box: Floats,
    law: Floats,
    full: Floats,
    offset: float,
    gear: Floats,
    min_gaps: tuple[float, float],
) -> tuple[float, float, float, float]:
    """Simulate one rollout.

    Returns (progress, m; time of contact, s, +∞: none; discomfort, m; distance from the path, m).
    """
    share, lookahead, dt, turns = gear
    top, pose = law[0] * full[0], np.zeros(3)
    v, w, at, time, discomfort = twist[0], twist[2], 0, 0.0, 0.0
    before, distance = _progress(path, pose, 0)
    progress = before
    for k in range(STEPS):
        angle = bearing(path, pose, at, offset, lookahead * law[2])
        if progress > (len(path) - 1) * SPACING - _END_TOLERANCE:
            # The sooner the end is reached the better.
            discomfort += top * (time - STEPS * GEARS[0, 2])
            break
        forward = share * top * max(math.cos(angle), 0.0)
        if turns > 0.0 and abs(angle) > TURNED:
            forward = 0.0
        # Speed and turn rate follow the deflection with limited accelerations.
        turn = min(max(law[1] * angle, -1.0), 1.0) * full[1]
        v += min(max(forward - v, -_FALLS * dt), _RISES * dt)
        w += min(max(turn - w, -_TURNS * dt), _TURNS * dt)
        half = pose[2] + 0.5 * w * dt
        pose[0] += v * dt * math.cos(half)
        pose[1] += v * dt * math.sin(half)
        pose[2] += w * dt
        time = (k + 1) * dt
        # Contact ends the rollout; small gaps cost in proportion to the speed.
        obstacle, person = _gaps(points, people, box, pose, time)
        if obstacle < min_gaps[0] or person < min_gaps[1]:
            return progress - before, time, discomfort / (k + 1), distance
        pace = min(abs(v) / top, 1.0) / STEPS
        discomfort += pace * _DISCOMFORT[0] * (1.0 - obstacle / COMFORT_GAPS[0]) ** 2
        discomfort += pace * _DISCOMFORT[1] * (1.0 - person / COMFORT_GAPS[1]) ** 2
        at = _next_index(path, pose, at)
        progress, distance = _progress(path, pose, at)
    return progress - before, np.inf, discomfort, distance


@njit(**CACHED)
def best_rollout(
    path: Floats,
    points: Floats,
    people: Floats,
    twist: Floats,
    box: Floats,
    law: Floats,
    full: Floats,
    offsets: Floats,
    current: float,
) -> tuple[int, float]:
    """Evaluate all offsets in all gears, and return (gear, offset) of the best rollout.

    Args:
        path: the desired one, (m, 4); see ``bearing``.
        points: obstacles, (n, 2), m.
        people: (p, 5) as (x, y, v_x, v_y, radius), m and m/s.
        twist: of the chair, (3,).
        box: bounds of its outline, (x, y low, x, y high), m.
        law: forward deflection, lateral deflection per radian, and lookahead, m.
        full: speed and turn rate at full deflection, (m/s, rad/s).
        offsets: to the left of the path, (b,), m.
        current: the offset driven now, m.

    Returns:
        −1 for the gear if no rollout is usable. A chair that is already nearer than the minimum
        gaps may drive away.
    """
    obstacle, person = _gaps(points, people, box, np.zeros(3), 0.0)
    min_gaps = (min(_MIN_GAPS[0], obstacle - 0.005), min(_MIN_GAPS[1], person - 0.01))
    best, chosen, highest, cost = -1, 0.0, -np.inf, np.inf
    for k in range(len(GEARS)):
        needed = _REACTION + GEARS[k, 0] * law[0] * full[0] / _FALLS
        for offset in offsets:
            progress, contact, discomfort, distance = _rollout(
                path, points, people, twist, box, law, full, offset, GEARS[k], min_gaps
            )
            if contact < needed or progress < _MIN_PROGRESS:
                continue
            loss = discomfort + _OFFSET_COST * distance + _SWITCH_COST * abs(offset - current)
            if contact < np.inf:
                loss += _BLOCKED * (1.0 - contact / (STEPS * GEARS[k, 2])) + _GOOD
            if progress - loss > highest:
                best, chosen, highest, cost = k, offset, progress - loss, loss
        if cost <= _GOOD:
            break
    return best, chosen


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
