"""What a sampled velocity of the dynamic window is worth: one compiled pass over all samples."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.robots.contact import STANDING, nearest_on_spine, wall_gap

_EVERY = 4
"""Steps between the points of a trajectory that are laid beside the path."""
_CLOSER = 0.01
"""By so much may a gap that is too small already shrink, m."""


@njit(cache=True)
def ramp(target: Floats, now: Floats, rise: Floats, fall: Floats, inputs: Floats) -> None:
    """Fill ``inputs`` (N, m): from ``now`` to ``target`` (m,) as fast as the limits allow.

    rise, fall: greatest change within a step, (m,); half of it in the first one.
    """
    for i in range(inputs.shape[1]):
        before = now[i]
        for k in range(inputs.shape[0]):
            share = 0.5 if k == 0 else 1.0
            before = min(max(target[i], before - share * fall[i]), before + share * rise[i])
            inputs[k, i] = before


@njit(cache=True)
def drive(start: Floats, inputs: Floats, twists: Floats, step: float, poses: Floats) -> None:
    """Fill ``poses`` (N+1, 3) with where inputs (N, m) lead; ``twists`` (m, 3) is linear in them.

    Each step drives with the heading of its middle, an arc's chord but for a term of third order.
    """
    poses[0] = start
    for k in range(inputs.shape[0]):
        vx, vy, w = 0.0, 0.0, 0.0
        for i in range(inputs.shape[1]):
            vx += inputs[k, i] * twists[i, 0]
            vy += inputs[k, i] * twists[i, 1]
            w += inputs[k, i] * twists[i, 2]
        heading = poses[k, 2] + 0.5 * step * w
        cos, sin = math.cos(heading), math.sin(heading)
        poses[k + 1, 0] = poses[k, 0] + step * (cos * vx - sin * vy)
        poses[k + 1, 1] = poses[k, 1] + step * (sin * vx + cos * vy)
        poses[k + 1, 2] = poses[k, 2] + step * w


@njit(cache=True)
def beside(path: Floats, x: float, y: float) -> tuple[float, float, float, float]:
    """(distance to a polyline (k, 2), length left beyond its nearest point, that point's x, y)."""
    best, left, behind, near_x, near_y = np.inf, 0.0, 0.0, path[0, 0], path[0, 1]
    for i in range(path.shape[0] - 2, -1, -1):
        dx, dy = path[i + 1, 0] - path[i, 0], path[i + 1, 1] - path[i, 1]
        px, py = x - path[i, 0], y - path[i, 1]
        length2 = dx * dx + dy * dy
        t = min(max((px * dx + py * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
        length = math.sqrt(length2)
        distance = math.hypot(px - t * dx, py - t * dy)
        if distance < best:
            best, left = distance, behind + (1.0 - t) * length
            near_x, near_y = path[i, 0] + t * dx, path[i, 1] + t * dy
        behind += length
    return best, left, near_x, near_y


@njit(cache=True)
def scores(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    targets: Floats,
    now: Floats,
    rise: Floats,
    fall: Floats,
    twists: Floats,
    start: Floats,
    steps: int,
    step: float,
    path: Floats,
    capsule: Floats,
    discs: Floats,
    people: Floats,
    radius: Floats,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    margins: Floats,
    braking: Floats,
    weights: Floats,
    last: Floats,
) -> Floats:
    """The cost (a,) of each sampled velocity, +inf: it is not admissible.

    Args:
        targets: (a, m) sampled inputs.
        now: what the wheels do, (m,).
        rise, fall: greatest change of the inputs within a step, (m,).
        twists: of the unit inputs, (m, 3).
        start: pose, (3,).
        steps, step: of the trajectories, s.
        path: what to follow, (k, 2), drawn on beyond the local goal by the distance that is
            aligned: else who has to look past the goal stops before it.
        capsule, discs: the footprint, as in ``Robot``.
        people: where they are at the trajectories' times, (p, N+1, 2).
        radius: of their bodies, (p,).
        distance, resolution, X_MG: the walls' distance field.
        margins: gap that is contact with (walls, people), and reach of the obstacle critic, m.
        braking: (reaction s, deceleration m/s², the same of turning rad/s²).
        weights: of (path, alignment, goal, goal's alignment, obstacles, changes), and the distance
            of the point ahead that is aligned, m.
        last: the inputs chosen before, (m,).
    """
    out = np.empty(targets.shape[0])
    inputs, poses = np.empty((steps, targets.shape[1])), np.empty((steps + 1, 3))
    contact, needed = np.empty(discs.shape[0]), np.empty(people.shape[0])
    for j in range(discs.shape[0]):
        contact[j] = min(margins[0], wall_gap(discs[j], start, distance, resolution, X_MG) - 1e-6)
    for i in range(people.shape[0]):
        gap = _to_body(capsule, start, people[i, 0], radius[i])
        needed[i] = min(margins[1], gap - _CLOSER)
    goal = path[path.shape[0] - 1]
    held = min(max(round(braking[0] / step), 1), steps)
    for a in range(targets.shape[0]):
        ramp(targets[a], now, rise, fall, inputs)
        drive(start, inputs, twists, step, poses)
        speed = (
            math.hypot(poses[held, 0] - poses[held - 1, 0], poses[held, 1] - poses[held - 1, 1])
            / step
        )
        turn = abs(poses[held, 2] - poses[held - 1, 2]) / step
        way, angle, off, crowd, points = 0.0, 0.0, 0.0, 0.0, 0
        safe = True
        for k in range(1, steps + 1):
            moved = math.hypot(poses[k, 0] - poses[k - 1, 0], poses[k, 1] - poses[k - 1, 1])
            turned = abs(poses[k, 2] - poses[k - 1, 2])
            if k > held:
                way, angle = way + moved, angle + turned
            nearest, touches = np.inf, False
            for j in range(discs.shape[0]):
                gap = wall_gap(discs[j], poses[k], distance, resolution, X_MG)
                nearest = min(nearest, gap)
                touches |= gap < contact[j]
            if touches:
                # Fox et al., eq. (14): v ≤ √(2 · dist · braking), for turns likewise
                far = way >= 0.5 * speed * speed / braking[1]
                safe = far and (speed > STANDING or angle >= 0.5 * turn * turn / braking[2])
            for i in range(people.shape[0]):
                gap = _to_body(capsule, poses[k], people[i, k], radius[i])
                nearest = min(nearest, gap)
                if gap < needed[i] and moved + turned > STANDING * step:
                    touches = True
                    safe &= k * step >= braking[0] + speed / braking[1]
            short = max(1.0 - max(nearest, 0.0) / margins[2], 0.0)
            crowd += short * short
            if touches:
                crowd += steps - k
                break
            if k % _EVERY == 0 or k == steps:
                off += beside(path, poses[k, 0], poses[k, 1])[0]
                points += 1
        if not safe:
            out[a] = np.inf
            continue
        end = poses[min(k, steps)]
        x = end[0] + weights[6] * math.cos(end[2])
        y = end[1] + weights[6] * math.sin(end[2])
        change = 0.0
        for i in range(targets.shape[1]):
            change += abs(targets[a, i] - last[i])
        out[a] = (
            weights[0] * off / max(points, 1)
            + weights[1] * beside(path, x, y)[0]
            + weights[2] * abs(beside(path, end[0], end[1])[1] - weights[6])
            + weights[3] * math.hypot(x - goal[0], y - goal[1])
            + weights[4] * crowd / steps
            + weights[5] * change
        )
    return out


@njit(cache=True, inline="always")
def _to_body(capsule: Floats, pose: Floats, body: Floats, radius: float) -> float:
    gap: float = nearest_on_spine(capsule, pose, body[0], body[1])[0] - capsule[4] - radius
    return gap
