"""First contact of a motion with walls and people: one answer for planners and safety gate.

The footprint is ``Robot.capsule`` against people and ``Robot.discs`` against walls; both contain
it. Motions are swept: tested between poses as well (0.16 s at 2.4 m/s closing speed is 0.38 m).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Floats32, Integers
from cohelm.maps import DistanceField
from cohelm.maps.distance import sample
from cohelm.messages import People, Predictions
from cohelm.robots.braking import STANDING
from cohelm.robots.capsule import gap_to_disc, nearest_on_spine_in_map
from cohelm.robots.clearance import share_of
from cohelm.robots.robot import Robot

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
WALKING = 0.15
"""A person who touches the robot and is faster than this walks on, m/s."""


class WallGrid(NamedTuple):
    """A distance field for compiled code."""

    distance: Floats32
    """(rows, cols) m."""
    resolution: float
    """m."""
    X_MG: Floats
    """(3,)."""


class _Bodies(NamedTuple):
    """Predicted bodies for compiled code: n people in h hypotheses."""

    positions: Floats
    """(n, h, N+1, 2) m."""
    velocities: Floats
    """(n, h, N+1, 2) m/s."""
    weight: Floats
    """(n, h) probabilities."""
    radius: Floats
    """(n,) m."""
    step: float
    """s."""


class ContactMargins(NamedTuple):
    """Gaps that count as contact.

    At time t, contact with a person is a gap below min(s·(people + ½·acceleration·t²), max(gap if
    the robot had stood still − 1 cm, min(8 cm, gap now − 1 cm))), where s grows from
    ``standing_share`` to 1 with the person's speed. So a person who comes close does not block the
    robot, and a person who would walk into it even if it stood finds it standing. The robot waits
    for a person who touches it and walks on, or who clearly overlaps it. Who follows behind a robot
    that drives away is no contact: braking would not help.
    """

    wall: float
    """Gap to a wall, m; never more than the gap at the start, so that a robot close to a wall may
    leave."""
    people: float
    """Gap to a person, m."""
    acceleration: float = 0.0
    """Possible change of people's velocity, m/s²."""
    min_probability: float = 0.0
    """Hypotheses below this are ignored, except the most likely one of each person."""
    extra: float = 0.0
    """Added to the gap to a person whatever its speed, m; the minimum distance of a therapist."""
    standing_share: float = 1.0
    """s of a standing person; s is 1 from 0.5 m/s on."""


def wall_grid(walls: DistanceField) -> WallGrid:
    """The arrays of a distance field."""
    return WallGrid(walls.distance, walls.resolution, walls.X_MG)


def first_contact(
    robot: Robot,
    poses: Floats,
    step: float,
    *,
    people: People,
    predictions: Predictions,
    walls: DistanceField,
    margins: ContactMargins,
) -> float:
    """Time when a motion first touches a wall or, while moving, a predicted body, s; else +inf.

    Args:
        robot: its footprint is tested.
        poses: of the motion, (k, 3); straight lines between them.
        step: between poses, s.
        people: their radii and present speeds.
        predictions: of these people; beyond the end they keep their velocity.
        walls: distance to everything that is not a person.
        margins: gaps that count as contact.
    """
    bodies = _Bodies(
        predictions.mean,
        predictions.velocity,
        predictions.weight,
        people.radius,
        predictions.step,
    )
    return _first_contact(
        robot.capsule, robot.discs, poses, step, bodies, wall_grid(walls), margins
    )


def touching(robot: Robot, pose: Floats, people: People) -> Booleans:
    """Mask of the people (n,) who touch a robot at ``pose`` now, within sensor accuracy."""
    return _touching(robot.capsule, np.asarray(pose, dtype=float), people.mean, people.radius)


@njit(cache=True)
def _touching(capsule: Floats, pose: Floats, people: Floats, radius: Floats) -> Booleans:
    out = np.empty(people.shape[0], dtype=np.bool_)
    for i in range(people.shape[0]):
        out[i] = gap_to_disc(capsule, pose, people[i, 0], people[i, 1], radius[i]) < TOUCHING
    return out


@njit(cache=True)
def wall_gap(disc: Floats, pose: Floats, walls: WallGrid) -> float:
    """Gap between a disc (x, y, radius) of a robot at ``pose`` and the nearest wall, m."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x = pose[0] + cos * disc[0] - sin * disc[1]
    y = pose[1] + sin * disc[0] + cos * disc[1]
    gap: float = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0] - disc[2]
    return gap


@njit(cache=True)
def circumscribed(discs: Floats) -> float:
    """Radius about the pose that holds all discs (c, 3), and the capsule with them, m."""
    around = 0.0
    for j in range(discs.shape[0]):
        around = max(around, math.hypot(discs[j, 0], discs[j, 1]) + discs[j, 2])
    return around


@njit(cache=True)
def wall_margins(discs: Floats, pose: Floats, walls: WallGrid, margin: float) -> Floats:
    """Contact gap of each disc (c,), m: reduced for a robot that starts closer to a wall."""
    out = np.empty(discs.shape[0])
    for j in range(discs.shape[0]):
        out[j] = min(margin, wall_gap(discs[j], pose, walls) - 1e-6)
    return out


@njit(cache=True)
def _first_contact(  # noqa: PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    discs: Floats,
    poses: Floats,
    step: float,
    bodies: _Bodies,
    walls: WallGrid,
    margins: ContactMargins,
) -> float:
    """Kernel of :func:`first_contact`: a circle about the robot skips what is surely clear."""
    pose = poses[0].copy()
    wall_margin = wall_margins(discs, pose, walls, margins.wall)
    counted = _counted(bodies.weight, margins.min_probability)
    shares, floor = _people_margins(capsule, pose, bodies, counted, margins.standing_share)
    around = circumscribed(discs)
    free = 0.0  # distance that the robot may travel before a wall can be near
    for k in range(poses.shape[0] - 1):
        # a robot that stands touches nothing
        moving = math.hypot(poses[k + 1, 0] - poses[k, 0], poses[k + 1, 1] - poses[k, 1])
        turned = poses[k + 1, 2] - poses[k, 2]
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
            for j in range(discs.shape[0] if free <= 0.0 else 0):
                if wall_gap(discs[j], pose, walls) < wall_margin[j]:
                    return time
            # people, compared with the gap that standing still would have kept
            for body in range(counted.shape[0]):
                i, j = counted[body, 0], counted[body, 1]
                most = shares[body] * (margins.people + 0.5 * margins.acceleration * time * time)
                most += margins.extra
                x, y = _at(bodies, i, j, time)
                dx, dy = x - pose[0], y - pose[1]
                far = around + bodies.radius[i] + most + _SAFE
                if dx * dx + dy * dy > far * far:
                    continue
                d, nx, ny, arm_x, arm_y, _ = nearest_on_spine_in_map(capsule, pose, x, y)
                gap = d - capsule[4] - bodies.radius[i]
                if gap >= most:
                    continue
                # velocity of the robot's surface towards the person
                vx = (poses[k + 1, 0] - poses[k, 0] + arm_x * turned) / step
                vy = (poses[k + 1, 1] - poses[k, 1] + arm_y * turned) / step
                leaving = vx * nx + vy * ny < -_LEAVING * math.hypot(vx, vy)
                if leaving and floor[body] < np.inf:
                    continue  # the robot drives away from somebody who follows
                stood = gap_to_disc(capsule, poses[0], x, y, bodies.radius[i])
                needed = min(most, max(stood - _NO_WORSE, floor[body]))
                if gap < needed or floor[body] == np.inf:
                    return time
    return np.inf


@njit(cache=True)
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


@njit(cache=True)
def _people_margins(
    capsule: Floats, pose: Floats, bodies: _Bodies, counted: Integers, standing_share: float
) -> tuple[Floats, Floats]:
    """(share of the margin, smallest gap that is not contact) of each counted body, (p,) each."""
    floor, shares = np.empty(len(counted)), np.empty(len(counted))
    for body in range(len(counted)):
        i, j = counted[body, 0], counted[body, 1]
        x, y = _at(bodies, i, j, 0.0)
        now = gap_to_disc(capsule, pose, x, y, bodies.radius[i])
        speed = math.hypot(bodies.velocities[i, j, 0, 0], bodies.velocities[i, j, 0, 1])
        walks = speed > WALKING
        shares[body] = share_of(speed, standing_share)
        floor[body] = min(_MIN_GAP, now - _NO_WORSE)
        if now < _OVERLAP or (now < TOUCHING and walks):
            floor[body] = np.inf
    return shares, floor


@njit(cache=True, inline="always")
def _at(bodies: _Bodies, i: int, j: int, time: float) -> tuple[float, float]:
    """Position of a body at ``time`` of its prediction; beyond the end it keeps its velocity."""
    m = min(int(time / bodies.step), bodies.positions.shape[2] - 1)
    rest = time - m * bodies.step
    x = bodies.positions[i, j, m, 0] + rest * bodies.velocities[i, j, m, 0]
    y = bodies.positions[i, j, m, 1] + rest * bodies.velocities[i, j, m, 1]
    return x, y
