"""Kernels of ``contact``: a swept motion against walls and predicted bodies."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED, callee
from cohelm.maps.distance import sample
from cohelm.robots.braking import STANDING
from cohelm.robots.capsule import gap_to_disc, nearest_on_spine_in_map
from cohelm.robots.clearance import BRISK, share_of
from cohelm.robots.wall_contact import WallGrid, circumscribed, wall_gap, wall_margins

_SUBSTEPS = 4
"""Tests within each step."""
TOUCHING = 0.03
"""A gap to a person below this is contact, m: perception is not more accurate."""
_MIN_GAP = 0.08
"""The robot stops before a gap to a person who walks into it becomes smaller than this, m:
predictions are less accurate than measurements."""
_SAFE = 0.01
"""Added to a distance at which contact is impossible, m."""
_OVERLAP = -0.06
"""The robot waits for a person who overlaps the footprint by more than this, m."""
_NO_WORSE = 0.01
"""A gap may be smaller by this than if the robot stood still, m."""
_LEAVING = 0.5
"""Cosine of the angle to the direction of motion from which on a person is behind the robot."""
_BESIDE = 0.25
"""Cosine of the angle to the direction of motion up to which a person is beside the robot."""
_SOON = 2.0
"""Time for which the robot is imagined to go on, s."""
_GOING_ON = 20
"""Number of tests in that time."""
WALKING = 0.15
"""A person who touches the robot and is faster than this walks on, m/s."""


class Bodies(NamedTuple):
    """Predicted bodies for compiled code: n people in h hypotheses."""

    positions: Floats
    """(n, h, N+1, 2) m."""
    velocities: Floats
    """(n, h, N+1, 2) m/s."""
    weight: Floats
    """(n, h) probabilities."""
    radius: Floats
    """(n,) m."""
    pace: Floats
    """(n,) recent highest speed of each person, m/s."""
    step: float
    """s."""


class ContactMargins(NamedTuple):
    """Gaps that count as contact.

    At time t, contact with a person is a gap below min(s·(min(people + growth·p·t, upper) +
    ½·acceleration·t²) + extra, max(gap if the robot had stood still − 1 cm, min(8 cm, gap now −
    1 cm))), where s grows from ``standing_share`` to 1 with the person's speed, and p from 0 to 1
    with its pace, both until 0.5 m/s. So a person who comes close does not block the robot, and a
    person who would walk into it even if it stood finds it standing. The robot waits for a person
    who touches it and walks on, or who clearly overlaps it. Who follows behind a robot that drives
    away is no contact: braking would not help.
    """

    wall: float
    """Gap to a wall, m; never more than the gap at the start, so that a robot close to a wall may
    leave."""
    people: float
    """Gap to a person now, m."""
    growth: float = 0.0
    """Growth of that gap with time, m/s; less at a slow pace, none for who stands."""
    upper: float = math.inf
    """Upper bound of that gap, m."""
    acceleration: float = 0.0
    """Possible change of people's velocity, m/s²."""
    min_probability: float = 0.0
    """Hypotheses below this are ignored, except the most likely one of each person."""
    extra: float = 0.0
    """Added to the gap to a person whatever its speed, m; the minimum distance of a therapist."""
    standing_share: float = 1.0
    """s of a standing person; s is 1 from 0.5 m/s on."""
    leaving: bool = False
    """Count people from whom the robot drives away, too."""
    followers: bool = True
    """Count people behind the robot, and people beside it who pass behind it if it goes on: braking
    brings them closer."""


@njit(**CACHED)
def contact_kernel(
    capsule: Floats,
    discs: Floats,
    poses: Floats,
    step: float,
    bodies: Bodies,
    walls: WallGrid,
    margins: ContactMargins,
    first: bool,
) -> Floats:
    """Kernel of ``contact.contact_times``: a circle about the robot skips what is surely clear.

    first: end at the first contact.
    """
    out = np.full(1 + bodies.weight.shape[0], np.inf)
    pose = poses[0].copy()
    wall_margin = wall_margins(discs, pose, walls, margins.wall)
    counted = _counted(bodies.weight, margins.min_probability)
    shares, growth, floor = _people_margins(capsule, pose, bodies, counted, margins)
    ignored = _ignored(capsule, poses, step, bodies, counted, margins, shares, floor)
    around = circumscribed(discs)
    free = 0.0  # distance that the robot may travel before a wall can be near
    for k in range(poses.shape[0] - 1):
        # a robot that stands touches nothing
        moving = math.hypot(poses[k + 1, 0] - poses[k, 0], poses[k + 1, 1] - poses[k, 1])
        free -= moving
        if moving < STANDING * step and abs(poses[k + 1, 2] - poses[k, 2]) < STANDING * step:
            continue
        for s in range(1, _SUBSTEPS + 1):
            share = s / _SUBSTEPS
            time = (k + share) * step
            for a in range(3):
                pose[a] = poses[k, a] + share * (poses[k + 1, a] - poses[k, a])
            # walls, where the circle may reach one
            if free <= 0.0:
                room = sample(walls.distance, walls.resolution, walls.X_MG, pose[0], pose[1])[0]
                free = room - around - margins.wall - 2.0 * walls.resolution
                free -= (1.0 - share) * moving
            if free <= 0.0 and out[0] == np.inf and _touches_wall(discs, pose, walls, wall_margin):
                out[0] = time
            possible = 0.5 * margins.acceleration * time * time
            for body in range(counted.shape[0]):
                i = counted[body, 0]
                if ignored[body] or out[1 + i] < np.inf:
                    continue
                wanted = min(margins.people + growth[body] * time, margins.upper)
                most = shares[body] * (wanted + possible) + margins.extra
                x, y = _at(bodies, i, counted[body, 1], time)
                dx, dy = x - pose[0], y - pose[1]
                far = around + bodies.radius[i] + most + _SAFE
                if dx * dx + dy * dy <= far * far and _touches(
                    capsule, poses, k, pose, x, y, bodies.radius[i], most, floor[body],
                    margins.leaving,
                ):  # fmt: skip
                    out[1 + i] = time
            if first and out.min() < np.inf:
                return out
    return out


@callee()
def _touches_wall(discs: Floats, pose: Floats, walls: WallGrid, margin: Floats) -> bool:
    """Check whether a disc is closer to a wall than its margin (c,)."""
    for j in range(discs.shape[0]):  # noqa: SIM110  # numba compiles no generator
        if wall_gap(discs[j], pose, walls) < margin[j]:
            return True
    return False


@callee()
def _touches(
    capsule: Floats,
    poses: Floats,
    k: int,
    pose: Floats,
    x: float,
    y: float,
    radius: float,
    most: float,
    floor: float,
    leaving: bool,
) -> bool:
    """Check a robot at ``pose`` in step k, and a body: its gap and that of standing still."""
    d, nx, ny, arm_x, arm_y, _ = nearest_on_spine_in_map(capsule, pose, x, y)
    gap = d - capsule[4] - radius
    if gap >= most:
        return False
    # motion of the robot's surface towards the person
    turned = poses[k + 1, 2] - poses[k, 2]
    x_moved, y_moved = poses[k + 1, 0] - poses[k, 0], poses[k + 1, 1] - poses[k, 1]
    moved, vx, vy = math.hypot(x_moved, y_moved), x_moved + arm_x * turned, y_moved + arm_y * turned
    leaves = vx * nx + vy * ny < -_LEAVING * math.hypot(vx, vy)
    leaves &= moved >= abs(turned) * math.hypot(arm_x, arm_y)  # turning escapes no person
    if leaves and floor < np.inf and not leaving:
        return False  # the robot drives away from a person who follows
    stood = gap_to_disc(capsule, poses[0], x, y, radius)
    return gap < min(most, max(stood - _NO_WORSE, floor)) or floor == np.inf


@callee()
def _ignored(
    capsule: Floats,
    poses: Floats,
    step: float,
    bodies: Bodies,
    counted: Integers,
    margins: ContactMargins,
    shares: Floats,
    floor: Floats,
) -> Booleans:
    """Mask (p,) of bodies that need no braking, see ``ContactMargins.followers``.

    A robot that has just begun to move waits for whom it touches.
    """
    out, pose = np.zeros(counted.shape[0], dtype=np.bool_), poses[0]
    if margins.followers:
        return out
    vx, vy = (poses[1, 0] - pose[0]) / step, (poses[1, 1] - pose[1]) / step
    for body in range(counted.shape[0]):
        if floor[body] < np.inf or math.hypot(vx, vy) > WALKING:
            wanted = shares[body] * margins.people + margins.extra
            out[body] = _needs_no_braking(capsule, pose, vx, vy, bodies, counted[body], wanted)
    return out


@callee()
def _needs_no_braking(
    capsule: Floats,
    pose: Floats,
    vx: float,
    vy: float,
    bodies: Bodies,
    body: Integers,
    wanted: float,
) -> bool:
    """Check that a person is behind a robot with velocity (vx, vy), or passes behind it.

    A person beside the robot passes behind it if going on keeps a gap ``wanted``.
    """
    i, j = body[0], body[1]
    speed = math.hypot(vx, vy)
    if speed < STANDING:
        return False
    x, y = _at(bodies, i, j, 0.0)
    dx, dy = x - pose[0], y - pose[1]
    ahead = (vx * dx + vy * dy) / max(speed * math.hypot(dx, dy), 1e-9)
    if ahead < -_LEAVING:
        return True
    if ahead > _BESIDE:
        return False
    at = pose.copy()
    for k in range(1, _GOING_ON + 1):
        time = _SOON * k / _GOING_ON
        at[0], at[1] = pose[0] + time * vx, pose[1] + time * vy
        x, y = _at(bodies, i, j, time)
        if gap_to_disc(capsule, at, x, y, bodies.radius[i]) < wanted:
            return False
    return True


@callee()
def _counted(weight: Floats, min_probability: float) -> Integers:
    """(person, hypothesis) (p, 2) of the probable hypotheses, and of each person's most likely."""
    n, h = weight.shape
    out, count = np.empty((n * h, 2), dtype=np.int64), 0
    for i in range(n):
        likely = 0.0
        for j in range(h):
            likely = max(likely, weight[i, j])
        for j in range(h):
            if weight[i, j] >= min(min_probability, likely):
                out[count, 0], out[count, 1] = i, j
                count += 1
    return out[:count]


@callee()
def _people_margins(
    capsule: Floats, pose: Floats, bodies: Bodies, counted: Integers, margins: ContactMargins
) -> tuple[Floats, Floats, Floats]:
    """(share of the margin, its growth, smallest gap that is not contact) of each body, (p,)."""
    floor, shares, growth = np.empty(len(counted)), np.empty(len(counted)), np.empty(len(counted))
    for body in range(len(counted)):
        i, j = counted[body, 0], counted[body, 1]
        x, y = _at(bodies, i, j, 0.0)
        now = gap_to_disc(capsule, pose, x, y, bodies.radius[i])
        speed = math.hypot(bodies.velocities[i, j, 0, 0], bodies.velocities[i, j, 0, 1])
        walks = speed > WALKING
        shares[body] = share_of(speed, margins.standing_share)
        growth[body] = margins.growth * min(bodies.pace[i] / BRISK, 1.0)
        floor[body] = min(_MIN_GAP, now - _NO_WORSE)
        if now < _OVERLAP or (now < TOUCHING and walks):
            floor[body] = np.inf
    return shares, growth, floor


@njit(**CACHED, inline="always")
def _at(bodies: Bodies, i: int, j: int, time: float) -> tuple[float, float]:
    """Position of a body at ``time`` of its prediction; beyond the end it keeps its velocity."""
    m = min(int(time / bodies.step), bodies.positions.shape[2] - 1)
    rest = time - m * bodies.step
    x = bodies.positions[i, j, m, 0] + rest * bodies.velocities[i, j, m, 0]
    y = bodies.positions[i, j, m, 1] + rest * bodies.velocities[i, j, m, 1]
    return x, y
