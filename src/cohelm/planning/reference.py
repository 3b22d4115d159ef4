"""Reference along a path: poses and speeds over the horizon.

The reference starts at the robot's projection on the path. Its speed is limited by curves, the goal
and the robot's acceleration, and it waits for a robot that must first turn toward the path.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, value
from cohelm.config import Model
from cohelm.geometry import arc_length
from cohelm.kernels import CACHED, callee
from cohelm.messages import Path, Reference
from cohelm.robots import Robot

_BACK, _AHEAD = 1.0, 2.0  # m of path searched behind and ahead of the last progress
_ABOUT = np.array([0.0, 0.0, np.pi])
_AMBIGUOUS = 0.4  # rad from a half turn within which the robot keeps its direction of turn


class ComfortLimits(Model):
    """Limits for driving a path that are stricter than the robot's; assumed."""

    lateral_acceleration: float = Field(0.6, gt=0.0, le=10.0)
    """v²κ in curves, m/s²."""
    deceleration: float = Field(0.6, gt=0.0, le=10.0)
    """Braking before curves and the goal, m/s²."""
    turn_share: float = Field(0.8, gt=0.0, le=1.0)
    """Share of the robot's turn rate that a curve may use."""
    approach: float = Field(1.0, gt=0.0, le=100.0)
    """Distance ahead at which a robot beside the path joins it, m."""
    creep: float = Field(0.05, ge=0.0, le=1.0)
    """Speed of the reference while the robot faces away, m/s."""


@value
class ReferenceSettings:
    """Horizon and limits of a reference."""

    steps: int
    """N."""
    step: float
    """Time between states, s."""
    speed: float
    """Wanted speed where nothing limits it, m/s; the robot's limit applies too."""
    robot: Robot
    comfort: ComfortLimits = ComfortLimits()
    backward: bool = False
    """The path is driven backwards: headings against its tangent, negative speeds."""


def make_reference(
    path: Path,
    pose: Floats,
    twist: Floats,
    settings: ReferenceSettings,
    *,
    progress: float | None = None,
) -> tuple[Reference, float]:
    """Compute the reference along ``path`` for a robot at ``pose``, and its position on the path.

    Headings are the path's tangent, unwrapped, on the branch nearest to the robot's own heading; a
    robot that is turning about keeps its direction of turn.

    Args:
        path: to follow.
        pose: X_MR, (3,).
        twist: robot frame, (3,).
        settings: horizon and limits.
        progress: returned by the last call for this path; the projection is searched near it, so
            that a path may cross itself. None: the nearest point of the whole path.

    Returns:
        (reference, arc length of the projection, m)
    """
    robot, comfort = settings.robot, settings.comfort
    along, line, heading, curvature = _geometry(path)
    pose, twist = np.asarray(pose, dtype=float), np.asarray(twist, dtype=float)
    if settings.backward:  # the robot turned about drives the path forward
        pose, twist = pose + _ABOUT, twist * np.array([-1.0, -1.0, 1.0])
    fastest = robot.max_reverse_speed if settings.backward else robot.max_speed
    wanted = min(max(settings.speed, 0.0), fastest)
    limits = np.array(
        [
            wanted,
            robot.max_acceleration,
            min(comfort.deceleration, robot.max_deceleration),
            comfort.lateral_acceleration,
            comfort.turn_share * robot.max_turn_rate,
            comfort.approach,
            min(comfort.creep, wanted),
        ]
    )
    start = -1.0 if progress is None else progress
    horizon = settings.steps, settings.step
    poses, speeds, at = _drive(
        along, line, heading, curvature, pose, twist, limits, start, *horizon
    )
    if settings.backward:
        poses, speeds = poses - _ABOUT, -speeds
    return Reference(step=settings.step, poses=poses, speeds=speeds), at


@lru_cache(maxsize=16)
def _geometry(path: Path) -> tuple[Floats, Floats, Floats, Floats]:
    """(arc length (k,), points (k, 2), unwrapped heading (k,), |curvature| (k,)) of a path.

    Repeated points are dropped. A path that is a single point has heading NaN: any heading.
    """
    s = arc_length(path.points)
    keep = np.concatenate([[True], np.diff(s) > 1e-9])
    s, points = s[keep], path.points[keep]
    if len(s) < 2:
        return s[:1], points[:1].copy(), np.full(1, np.nan), np.zeros(1)
    directions = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    middle = 0.5 * (s[1:] + s[:-1])
    heading = np.interp(s, middle, directions)
    turn = np.abs(np.diff(directions)) / np.diff(middle)
    curvature = np.concatenate([[0.0], turn, [0.0]])
    return s, np.ascontiguousarray(points), heading, curvature


@njit(**CACHED)
def _drive(
    along: Floats,
    line: Floats,
    heading: Floats,
    curvature: Floats,
    pose: Floats,
    twist: Floats,
    limits: Floats,
    progress: float,
    steps: int,
    step: float,
) -> tuple[Floats, Floats, float]:
    """(poses (N+1, 3), speeds (N+1,), arc length of the projection)."""
    wanted, speed_up, brake, lateral, turn, approach, creep = limits
    end = along[-1]
    at, aside = _project(along, line, pose[0], pose[1], progress)
    allowed = _speed_limits(along, curvature, wanted, brake, lateral, turn)
    poses, speeds = np.empty((steps + 1, 3)), np.empty(steps + 1)
    branch, error = _branch(_interpolate(along, heading, at), aside, approach, pose[2], twist[2])
    s = at
    v = min(max(twist[0], 0.0), _limit_at(along, allowed, s))
    for k in range(steps + 1):
        if k > 0:
            # The remaining turn decreases as the robot turns; until then the reference waits.
            facing = max(math.cos(max(error - turn * step * k, 0.0)), 0.0)
            faster = min(v + speed_up * step, max(wanted * facing, creep))
            v_next = min(faster, _limit_ahead(along, allowed, s, v, step, faster))
            s = min(s + 0.5 * (v + v_next) * step, end)
            v = v_next
            if v <= 0.0 and end - s < 0.5 * brake * step * step:
                s = end  # the last fraction of a step
        poses[k, 0] = _interpolate(along, line[:, 0], s)
        poses[k, 1] = _interpolate(along, line[:, 1], s)
        tangent = _interpolate(along, heading, s)
        poses[k, 2] = pose[2] if math.isnan(tangent) else tangent + branch
        speeds[k] = v if s < end else 0.0
    return poses, speeds, at


@callee()
def _project(
    along: Floats, line: Floats, x: float, y: float, progress: float
) -> tuple[float, float]:
    """(arc length of the nearest point, signed distance to it: positive left of the path)."""
    best, at, aside = np.inf, along[0], 0.0
    n = along.shape[0]
    if n == 1:
        return at, 0.0
    low, high = -np.inf, np.inf
    if progress >= 0.0:
        low, high = min(progress, along[-1]) - _BACK, progress + _AHEAD
    for i in range(n - 1):
        if along[i + 1] < low or along[i] > high:
            continue
        dx, dy = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
        px, py = x - line[i, 0], y - line[i, 1]
        length = along[i + 1] - along[i]
        t = min(max((px * dx + py * dy) / (length * length), 0.0), 1.0)
        distance = math.hypot(px - t * dx, py - t * dy)
        if distance < best:
            best, at = distance, along[i] + t * length
            aside = distance if dx * py - dy * px > 0.0 else -distance
    return at, aside


@callee()
def _speed_limits(
    along: Floats, curvature: Floats, wanted: float, brake: float, lateral: float, turn: float
) -> Floats:
    """Squared speed (k,) at each point of the path that allows for every limit ahead."""
    n = along.shape[0]
    out = np.empty(n)
    out[n - 1] = 0.0
    for i in range(n - 2, -1, -1):
        kappa = max(curvature[i], 1e-9)
        curve = min(wanted * wanted, lateral / kappa, (turn / kappa) ** 2)
        out[i] = min(curve, out[i + 1] + 2.0 * brake * (along[i + 1] - along[i]))
    return out


@callee()
def _limit_at(along: Floats, allowed: Floats, s: float) -> float:
    """Speed limit at arc length ``s``: linear in the squared speed between points."""
    return math.sqrt(max(_interpolate(along, allowed, s), 0.0))


@callee()
def _limit_ahead(
    along: Floats, allowed: Floats, s: float, v: float, step: float, most: float
) -> float:
    """Highest speed v' ≤ ``most`` that respects the limit at the end of a step from ``s``."""
    low, high = 0.0, most
    if most <= _limit_at(along, allowed, s + 0.5 * (v + most) * step):
        return most
    for _ in range(30):
        middle = 0.5 * (low + high)
        if middle <= _limit_at(along, allowed, s + 0.5 * (v + middle) * step):
            low = middle
        else:
            high = middle
    return low if low > 1e-6 else 0.0


@callee()
def _branch(
    tangent: float, aside: float, approach: float, heading: float, turning: float
) -> tuple[float, float]:
    """(offset of the path's headings to the robot's branch, remaining turn), rad."""
    if math.isnan(tangent):
        return 0.0, 0.0
    turn = math.pi - (math.pi - (tangent - heading)) % (2.0 * math.pi)
    if math.pi - abs(turn) < _AMBIGUOUS and turn * turning < -0.05 * abs(turn):
        turn -= math.copysign(2.0 * math.pi, turn)
    branch = heading + turn - tangent
    joining = turn - math.atan2(aside, approach)
    return branch, abs(joining)


@callee()
def _interpolate(xs: Floats, ys: Floats, x: float) -> float:
    """Linear interpolation; the end values hold beyond the ends."""
    n = xs.shape[0]
    if x <= xs[0]:
        return float(ys[0])
    if x >= xs[n - 1]:
        return float(ys[n - 1])
    low, high = 0, n - 1
    while high - low > 1:
        middle = (low + high) // 2
        if xs[middle] <= x:
            low = middle
        else:
            high = middle
    t = (x - xs[low]) / (xs[high] - xs[low])
    return float(ys[low] * (1.0 - t) + ys[high] * t)
