"""What the kernel reads of a problem: path, people, groups and walls as plain arrays."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.control.api import LocalProblem
from cohelm.control.candidates.hulls import Hulls, hulls_of
from cohelm.robots.contact import wall_gap
from cohelm.shapes import PRINTED

SPACING = 0.1
"""Between the samples of the path, m."""
BEYOND = 2.5
"""The path goes straight on so far beyond its end, m."""
_CREEP = 0.3
"""Arcs are tried up to this speed even where the reference stands, m/s."""
_SLACK = 1e-9


class Road(NamedTuple):
    """The path, evenly sampled, and where on it the reference is when."""

    samples: Floats
    """(q, 4): x, y and the unit tangent."""
    wanted: Floats
    """(N+1,) arc length of the reference at each step, m."""
    heading: Floats
    """(q, 2) unit vector of the wanted heading."""
    pace: float
    """The reference's greatest speed, and at least the creeping speed, m/s."""


class Crowd(NamedTuple):
    """Everybody in each of their futures, P pairs of person and hypothesis."""

    states: Floats
    """(P, N+1, 8): x, y, axis of motion (cos, sin), 1/2σ² ahead, behind and aside, deviation."""
    weight: Floats
    """(P,) probability."""
    radius: Floats
    """(P,) m."""
    fastest: Floats
    """(P,) m/s, over all steps."""
    scale: float
    """c of eq. (5)."""
    printed: bool
    floor: float
    """Least reach of a space, m."""
    reach: float
    """Greatest reach of any space, m."""


class Walls(NamedTuple):
    """Distance to all that is not a person."""

    distance: Floats32
    resolution: float
    X_MG: Floats
    margin: Floats
    """(c,) gap of each disc that counts as contact, m."""


class Body(NamedTuple):
    """The robot: where it is, how it moves, how large it is."""

    start: Floats
    """(3,) pose."""
    now: Floats
    """(m,) what the wheels do."""
    low: Floats
    high: Floats
    rise: Floats
    """(m,) greatest change in a step; so is the next."""
    fall: Floats
    translating: int
    top_speed: float
    capsule: Floats
    discs: Floats
    around: float
    """Radius about the pose that holds all of it, m."""


class Scene(NamedTuple):
    """All of it."""

    step: float
    """s."""
    steps: int
    """N."""
    blur: float
    """A step is driven along the heading that it begins with, and this many seconds of turning: 0
    as planners roll out, more where a step stands for several of theirs."""
    road: Road
    crowd: Crowd
    hulls: Hulls
    walls: Walls
    body: Body


def scene_of(problem: LocalProblem, now: Floats, steps: int, wall_margin: float) -> Scene:
    """The problem over ``steps`` of its own, which may be more than it has.

    Beyond the end of its predictions people keep their last velocity, and the reference its last
    speed and heading.
    """
    step = problem.reference.step
    return Scene(
        step=step,
        steps=steps,
        blur=problem.robot.motion.turned * step,
        road=_road(problem, steps),
        crowd=_crowd(problem, steps),
        hulls=hulls_of(problem.spaces.groups, steps),
        walls=_walls(problem, wall_margin),
        body=_body(problem, now),
    )


def coarser(scene: Scene, stride: int) -> Scene:
    """The same with ``stride`` steps in one; ``scene.steps`` must be a multiple of it."""
    if stride == 1:
        return scene
    every = np.s_[::stride]
    crowd, hulls, body = scene.crowd, scene.hulls, scene.body
    return scene._replace(
        step=stride * scene.step,
        steps=scene.steps // stride,
        blur=scene.blur + 0.5 * (stride - 1) * scene.step,
        road=scene.road._replace(wanted=scene.road.wanted[every].copy()),
        crowd=crowd._replace(states=crowd.states[:, every].copy()),
        hulls=hulls._replace(
            support=hulls.support[:, every].copy(), disc=hulls.disc[:, every].copy()
        ),
        body=body._replace(rise=stride * body.rise, fall=stride * body.fall),
    )


def _road(problem: LocalProblem, steps: int) -> Road:
    reference = problem.reference
    speeds = reference.speeds
    samples, wanted, angle = _sampled(
        reference.poses, steps, reference.step * abs(float(speeds[-1]))
    )
    heading = np.empty((len(angle), 2))
    np.cos(angle, out=heading[:, 0])
    np.sin(angle, out=heading[:, 1])
    pace = max(float(speeds.max()), min(_CREEP, problem.top_speed), 0.05)
    return Road(samples, wanted, heading, pace)


@njit(cache=True)
def _sampled(poses: Floats, steps: int, stride: float) -> tuple[Floats, Floats, Floats]:
    """(samples, wanted, angle of the wanted heading (q,)); see ``Road``.

    stride: what the reference gains a step beyond its end, m.
    """
    known = poses.shape[0]
    s, x, y = np.empty(known + 1), np.empty(known + 1), np.empty(known + 1)
    turn, wanted = np.empty(known + 1), np.empty(steps + 1)
    along, n = 0.0, 0
    for k in range(known):
        gap = 0.0
        if k > 0:
            gap = np.hypot(poses[k, 0] - poses[k - 1, 0], poses[k, 1] - poses[k - 1, 1])
            along += gap
        wanted[k] = along
        if k == 0 or gap > _SLACK:
            s[n], x[n], y[n], turn[n] = along, poses[k, 0], poses[k, 1], poses[k, 2]
            n += 1
    for k in range(known, steps + 1):
        wanted[k] = along + (k - known + 1) * stride
    if n > 1:
        ahead_x, ahead_y = x[n - 1] - x[n - 2], y[n - 1] - y[n - 2]
    else:
        ahead_x, ahead_y = np.cos(poses[known - 1, 2]), np.sin(poses[known - 1, 2])
    norm = np.hypot(ahead_x, ahead_y)
    ahead_x, ahead_y = ahead_x / norm, ahead_y / norm
    tail = wanted[steps] - along + BEYOND
    s[n], x[n], y[n] = s[n - 1] + tail, x[n - 1] + tail * ahead_x, y[n - 1] + tail * ahead_y
    turn[n] = poses[known - 1, 2]
    count = int(np.ceil(s[n] / SPACING)) + 1
    samples, angle = np.empty((count, 4)), np.empty(count)
    j = 0
    for i in range(count):
        at = SPACING * i
        while j < n and s[j + 1] <= at:
            j += 1
        if j == n:
            samples[i, 0], samples[i, 1], angle[i] = x[n], y[n], turn[n]
            continue
        rest, length = at - s[j], s[j + 1] - s[j]
        samples[i, 0] = (x[j + 1] - x[j]) / length * rest + x[j]
        samples[i, 1] = (y[j + 1] - y[j]) / length * rest + y[j]
        angle[i] = (turn[j + 1] - turn[j]) / length * rest + turn[j]
    for i in range(count):
        dx, dy = 0.0, 0.0
        if i < count - 1:
            dx, dy = samples[i + 1, 0] - samples[i, 0], samples[i + 1, 1] - samples[i, 1]
        if np.hypot(dx, dy) < 0.5 * SPACING:
            dx, dy = ahead_x, ahead_y
        norm = np.hypot(dx, dy)
        samples[i, 2], samples[i, 3] = dx / norm, dy / norm
    return samples, wanted, angle


def _crowd(problem: LocalProblem, steps: int) -> Crowd:
    p, s = problem.predictions, problem.spaces
    states = _crowd_states(
        p.mean, p.velocity, p.deviation, s.axis, s.front, s.side, s.rear, steps, p.step
    )
    weight, radius, fastest, front = _each(p.weight, problem.people.radius, p.velocity, s.front)
    printed = s.kind == PRINTED
    reach = 2.0 * s.scale * front**2 if printed else math.sqrt(2.0 * s.scale) * front
    return Crowd(
        states=states,
        weight=weight,
        radius=radius,
        fastest=fastest,
        scale=s.scale,
        printed=printed,
        floor=s.floor,
        reach=max(reach, s.floor),
    )


@njit(cache=True)
def _each(
    weight: Floats, radius: Floats, velocity: Floats, front: Floats
) -> tuple[Floats, Floats, Floats, float]:
    """(weight, radius, fastest (P,) of ``Crowd``; the greatest of ``front``)."""
    n, h, states = front.shape
    likely, wide, fastest, most = np.empty(n * h), np.empty(n * h), np.zeros(n * h), 0.0
    for i in range(n):
        for j in range(h):
            likely[i * h + j], wide[i * h + j] = weight[i, j], radius[i]
            for k in range(velocity.shape[2]):
                speed = math.hypot(velocity[i, j, k, 0], velocity[i, j, k, 1])
                fastest[i * h + j] = max(fastest[i * h + j], speed)
            for k in range(states):
                most = max(most, front[i, j, k])
    return likely, wide, fastest, most


@njit(cache=True)
def _crowd_states(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    mean: Floats,
    velocity: Floats,
    deviation: Floats,
    axis: Floats,
    front: Floats,
    side: Floats,
    rear: Floats,
    steps: int,
    step: float,
) -> Floats:
    n, h, known = mean.shape[0], mean.shape[1], mean.shape[2]
    out = np.empty((n * h, steps + 1, 8))
    for i in range(n):
        for j in range(h):
            row = out[i * h + j]
            for k in range(steps + 1):
                m = min(k, known - 1)
                rest = (k - m) * step
                vx, vy = velocity[i, j, m, 0], velocity[i, j, m, 1]
                row[k, 0] = mean[i, j, m, 0] + rest * vx
                row[k, 1] = mean[i, j, m, 1] + rest * vy
                row[k, 2], row[k, 3] = np.cos(axis[i, j, m]), np.sin(axis[i, j, m])
                row[k, 4] = 0.5 / front[i, j, m] ** 2
                row[k, 5] = 0.5 / rear[i, j, m] ** 2
                row[k, 6] = 0.5 / side[i, j, m] ** 2
                row[k, 7] = deviation[i, j, m]
    return out


def _walls(problem: LocalProblem, margin: float) -> Walls:
    walls = problem.walls
    discs = problem.robot.discs
    return Walls(
        distance=np.ascontiguousarray(walls.distance),
        resolution=walls.resolution,
        X_MG=walls.X_MG,
        margin=_margins(discs, problem.pose, walls.distance, walls.resolution, walls.X_MG, margin),
    )


@njit(cache=True)
def _margins(
    discs: Floats,
    pose: Floats,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    margin: float,
) -> Floats:
    """(c,) as ``Walls.margin``: who stands close to a wall may leave."""
    out = np.empty(discs.shape[0])
    for j in range(discs.shape[0]):
        out[j] = min(margin, wall_gap(discs[j], pose, distance, resolution, X_MG) - 1e-6)
    return out


def _body(problem: LocalProblem, now: Floats) -> Body:
    robot, step = problem.robot, problem.reference.step
    low, high, rise, fall = problem.input_bounds()
    discs = robot.discs
    return Body(
        start=problem.pose.copy(),
        now=np.array(now, dtype=float),
        low=low,
        high=high,
        rise=rise * step,
        fall=fall * step,
        translating=robot.motion.translating,
        top_speed=problem.top_speed,
        capsule=robot.capsule.copy(),
        discs=discs.copy(),
        around=max(math.hypot(x, y) + radius for x, y, radius in discs.tolist()),
    )
