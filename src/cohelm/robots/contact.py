"""Where a robot's footprint would touch something: one answer for planner and gate.

The footprint is ``Robot.capsule`` against people and ``Robot.discs`` against walls; both contain
it. Motions are swept: tested between steps as well (0.16 s at 2.4 m/s of closing speed is 0.38 m).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Floats32
from cohelm.maps import DistanceField
from cohelm.maps.distance import sample
from cohelm.messages import People, Predictions
from cohelm.robots.robot import Robot
from cohelm.robots.spine import foot_on_spine

_SUBSTEPS = 4
"""Tests within each step."""
TOUCHING = 0.03
"""A gap to a person below this is no gap, m: what is seen is not better than that."""
_LEAST = 0.08
"""The robot stands before a gap to who walks into it anyway becomes smaller than this, m: what is
predicted is not as good as what is seen."""
_SAFE = 0.01
"""Added to what is surely far enough, m."""
_OVERLAP = -0.06
"""A body that reaches farther than this into the footprint is waited for, m."""
_NO_WORSE = 0.01
"""By so much a gap may be smaller than if the robot stood still, m."""
WALKING = 0.15
"""Who touches the robot and is faster than this walks on, m/s."""
BRISK = 0.5
"""From this speed on the whole of margins to people counts, m/s; less below."""
STANDING = 0.02
"""A robot slower than this stands, m/s and rad/s."""


def first_contact(  # noqa: PLR0913  # keyword-only, one meaning each
    robot: Robot,
    poses: Floats,
    step: float,
    *,
    people: People,
    predictions: Predictions,
    walls: DistanceField,
    margin: float,
    people_margin: float,
    agility: float = 0.0,
    at_least: float = 0.0,
    standing: float = 1.0,
) -> float:
    """When a motion would first touch a wall or, while moving, a predicted body, s; else +inf.

    Args:
        robot: whose footprint.
        poses: of the motion, (k, 3); straight lines between them.
        step: between poses, s.
        people: whose bodies.
        predictions: of them; beyond their end people keep their velocity.
        walls: distance to all that is not a person.
        margin: gap to a wall that counts as contact, m; never more than the gap at the start, so
            that a robot that stands close to one may leave.
        people_margin: the same for people. At time t contact is a gap below min(s·(people_margin +
            ½·agility·t²), max(gap if the robot had stood still − 1 cm, min(8 cm, gap now − 1 cm))),
            where s grows from ``standing`` to 1 with the person's speed. So who comes close does
            not hold the robot fast, and who would walk into it even if it stood finds it standing.
            Who touches the robot and walks on, or clearly overlaps it, is waited for.
        agility: how fast people may change their velocity, m/s².
        at_least: the probability from which on a hypothesis counts; the likeliest one of each
            person always does.
        standing: s of who stands; s is 1 from 0.5 m/s on.
    """
    n, h, states = predictions.mean.shape[:3]
    return float(
        _first_contact(
            robot.capsule,
            robot.discs,
            poses,
            step,
            predictions.mean.reshape(n * h, states, 2),
            np.ascontiguousarray(predictions.velocity).reshape(n * h, states, 2),
            np.repeat(people.radius, h),
            _counting(predictions.weight, at_least),
            predictions.step,
            walls.distance,
            walls.resolution,
            walls.X_MG,
            margin,
            people_margin,
            agility,
            standing,
        )
    )


def touching(robot: Robot, pose: Floats, people: People) -> Booleans:
    """Who touches a robot at ``pose`` now, as far as can be seen, (n,)."""
    return _touching(robot.capsule, np.asarray(pose, dtype=float), people.mean, people.radius)


@njit(cache=True)
def _touching(capsule: Floats, pose: Floats, people: Floats, radius: Floats) -> Booleans:
    out = np.empty(people.shape[0], dtype=np.bool_)
    for i in range(people.shape[0]):
        distance = nearest_on_spine(capsule, pose, people[i, 0], people[i, 1])[0]
        out[i] = distance - capsule[4] - radius[i] < TOUCHING
    return out


def braking(
    robot: Robot,
    pose: Floats,
    now: Floats,
    command: Floats,
    *,
    hold: float,
    deceleration: float,
    step: float,
) -> Floats:
    """Poses (k, 3) of a command obeyed for a while, then braking to a stand along the same arc.

    The turn has to come to an end as well, which takes longer than the speed where the robot turns
    on the spot; and the wheels lag behind what they are told.

    Args:
        robot: its kinematics and limits.
        pose: where it is, (3,).
        now: what the wheels do, (m,); they change from there no faster than the limits allow.
        command: inputs (m,).
        hold: how long the command acts, s, the drive's lag included.
        deceleration: of braking, m/s².
        step: between poses, s.
    """
    _, _, rise, fall = robot.input_bounds
    inputs = _fading(now, command, rise, fall, hold, deceleration, robot.actuation_lag, step)
    return robot.motion.rollout(pose, inputs, step)


@njit(cache=True)
def _fading(  # noqa: PLR0917  # a kernel takes plain arrays
    now: Floats,
    command: Floats,
    rise: Floats,
    fall: Floats,
    hold: float,
    deceleration: float,
    lag: float,
    step: float,
) -> Floats:
    """Inputs (k, m) of :func:`braking`: all fade together, in the time that the slowest needs.

    The last input is the turn rate, all others are speeds.
    """
    m = len(now)
    peak = np.empty(m)
    speed = 0.0
    for i in range(m):
        peak[i] = now[i] + min(max(command[i] - now[i], -fall[i] * hold), rise[i] * hold)
        if i < m - 1:
            speed += peak[i] * peak[i]
    fading = max(math.sqrt(speed) / deceleration, abs(peak[m - 1]) / fall[m - 1], 1e-3)
    greatest = max(math.sqrt(speed), abs(peak[m - 1]))
    begins = max(hold - lag, 0.0)
    tail = lag * math.log(max(greatest * lag / fading, STANDING) / (0.5 * STANDING))
    count = math.ceil((max(begins + fading + tail, hold)) / step - 1e-9)
    out = np.empty((max(count, 2), m))
    for k in range(len(out)):
        left = _lagged((k + 0.5) * step - begins, fading, lag)
        for i in range(m):
            change = min((k + 1.0) * step, hold)
            acting = now[i] + min(max(command[i] - now[i], -fall[i] * change), rise[i] * change)
            out[k, i] = left * acting
    return out


@njit(cache=True, inline="always")
def _lagged(time: float, fading: float, lag: float) -> float:
    """What is left of an input ``time`` after its set-point began to fade: a ramp through a lag."""
    if time <= 0.0:
        return 1.0
    if lag <= 0.0:
        return max(1.0 - time / fading, 0.0)
    ramp = min(time, fading)
    left = 1.0 - (ramp - lag * (1.0 - math.exp(-ramp / lag))) / fading
    return left * math.exp(-(time - ramp) / lag)


def _counting(weight: Floats, at_least: float) -> Booleans:
    """Which hypotheses (n·h,) count, from their probabilities (n, h)."""
    likeliest = weight.max(axis=1, initial=0.0, keepdims=True)
    return np.ravel(weight >= np.minimum(at_least, likeliest))


@njit(cache=True, inline="always")
def nearest_on_spine(
    capsule: Floats, pose: Floats, x: float, y: float
) -> tuple[float, float, float, float, float, bool]:
    """(distance from spine, unit vector to the point, arm rotated by 90°, inside the spine).

    capsule: as ``Robot.capsule``.  The arm leads from the pose to the spine's nearest point; all in
    the map frame.
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    distance, ex, ey, sx, sy, inside = foot_on_spine(capsule, cos, sin, x - pose[0], y - pose[1])
    nx, ny = cos * ex - sin * ey, sin * ex + cos * ey
    arm_x, arm_y = -(sin * sx + cos * sy), cos * sx - sin * sy
    return distance, nx, ny, arm_x, arm_y, inside


@njit(cache=True)
def wall_gap(
    disc: Floats, pose: Floats, distance: Floats32, resolution: float, X_MG: Floats
) -> float:
    """Gap between a disc (x, y, radius) of a robot at ``pose`` and the nearest wall, m."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x = pose[0] + cos * disc[0] - sin * disc[1]
    y = pose[1] + sin * disc[0] + cos * disc[1]
    gap: float = sample(distance, resolution, X_MG, x, y)[0] - disc[2]
    return gap


@njit(cache=True)
def _first_contact(  # noqa: PLR0912, PLR0913, PLR0917  # a kernel: one pass, plain arrays
    capsule: Floats,
    discs: Floats,
    poses: Floats,
    step: float,
    positions: Floats,
    velocities: Floats,
    radius: Floats,
    counts: Booleans,
    person_step: float,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    margin: float,
    people_margin: float,
    agility: float,
    standing: float,
) -> float:
    """The kernel of :func:`first_contact`; walls near the discs, people near the capsule.

    A look from afar skips what is surely clear: ``around``, taken from the discs, holds the capsule
    as well, which is their spine with their radius.
    """
    people = positions.shape[0]
    pose = poses[0].copy()
    wall_margin = np.empty(discs.shape[0])
    for j in range(discs.shape[0]):
        gap = wall_gap(discs[j], pose, distance, resolution, X_MG)
        wall_margin[j] = min(margin, gap - 1e-6)
    floor, share_of = np.empty(people), np.empty(people)
    for i in range(people):
        now = _body_gap(capsule, pose, positions[i], velocities[i], radius[i], person_step, 0.0)
        speed = math.hypot(velocities[i, 0, 0], velocities[i, 0, 1])
        walks = speed > WALKING
        share_of[i] = standing + (1.0 - standing) * min(speed / BRISK, 1.0)
        floor[i] = min(_LEAST, now - _NO_WORSE)
        if now < _OVERLAP or (now < TOUCHING and walks):
            floor[i] = np.inf
    around = 0.0  # radius about the pose that holds all of the robot
    for j in range(discs.shape[0]):
        around = max(around, math.hypot(discs[j, 0], discs[j, 1]) + discs[j, 2])
    free = 0.0  # how far the robot may go before a wall can be near
    for k in range(poses.shape[0] - 1):
        moving = math.hypot(poses[k + 1, 0] - poses[k, 0], poses[k + 1, 1] - poses[k, 1])
        free -= moving
        if moving < STANDING * step and abs(poses[k + 1, 2] - poses[k, 2]) < STANDING * step:
            continue
        for s in range(1, _SUBSTEPS + 1):
            share = s / _SUBSTEPS
            time = (k + share) * step
            for a in range(3):
                pose[a] = poses[k, a] + share * (poses[k + 1, a] - poses[k, a])
            if free <= 0.0:
                room = sample(distance, resolution, X_MG, pose[0], pose[1])[0]
                free = room - around - margin - 2.0 * resolution
                free -= (1.0 - share) * moving
            for j in range(discs.shape[0] if free <= 0.0 else 0):
                if wall_gap(discs[j], pose, distance, resolution, X_MG) < wall_margin[j]:
                    return time
            m = min(int(time / person_step), positions.shape[1] - 1)
            rest = time - m * person_step
            for i in range(people):
                if not counts[i]:
                    continue
                most = share_of[i] * (people_margin + 0.5 * agility * time * time)
                dx = positions[i, m, 0] + rest * velocities[i, m, 0] - pose[0]
                dy = positions[i, m, 1] + rest * velocities[i, m, 1] - pose[1]
                far = around + radius[i] + most + _SAFE
                if dx * dx + dy * dy > far * far:  # the cheapest look first
                    continue
                gap = _body_gap(
                    capsule, pose, positions[i], velocities[i], radius[i], person_step, time
                )
                if gap >= most:
                    continue
                stood = _body_gap(
                    capsule, poses[0], positions[i], velocities[i], radius[i], person_step, time
                )
                needed = min(most, max(stood - _NO_WORSE, floor[i]))
                if gap < needed or floor[i] == np.inf:
                    return time
    return np.inf


@njit(cache=True, inline="always")
def _body_gap(  # noqa: PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    pose: Floats,
    positions: Floats,
    velocities: Floats,
    radius: float,
    step: float,
    time: float,
) -> float:
    """Gap between the footprint and a body at ``time`` of its prediction (N+1, 2), m."""
    m = min(int(time / step), positions.shape[0] - 1)
    rest = time - m * step
    x = positions[m, 0] + rest * velocities[m, 0]
    y = positions[m, 1] + rest * velocities[m, 1]
    gap: float = nearest_on_spine(capsule, pose, x, y)[0] - capsule[4] - radius
    return gap
