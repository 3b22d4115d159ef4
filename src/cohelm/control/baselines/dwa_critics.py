"""What a sampled velocity of the dynamic window is worth: one compiled pass over all samples."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.maps.distance import sample
from cohelm.robots.contact import STANDING, nearest_on_spine, wall_gap

AT_REST = 1e-6
"""Inputs up to this do not move the robot, m/s and rad/s."""
_EVERY = 4
"""Steps between the points of a trajectory that are laid beside the path."""
_CLOSER = 0.01
"""By so much may a gap that is too small already shrink, m."""
_SAFE = 0.01
"""Added to what is surely far enough, m."""
_TIE = 1e-6
"""Costs that differ by less may be a tie."""
_ROUNDING = 1e-9
"""More than a square may be wrong by, as a share of it."""


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
    enough = np.inf
    for i in range(path.shape[0] - 2, -1, -1):
        dx, dy = path[i + 1, 0] - path[i, 0], path[i + 1, 1] - path[i, 1]
        px, py = x - path[i, 0], y - path[i, 1]
        length2 = dx * dx + dy * dy
        t = min(max((px * dx + py * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
        length = math.sqrt(length2)
        qx, qy = px - t * dx, py - t * dy
        if qx * qx + qy * qy <= enough:  # a look without the dear root
            distance = math.hypot(qx, qy)
            if distance < best:
                best, left = distance, behind + (1.0 - t) * length
                near_x, near_y = path[i, 0] + t * dx, path[i, 1] + t * dy
                enough = best * best * (1.0 + _ROUNDING)
        behind += length
    return best, left, near_x, near_y


@njit(cache=True)
def scores(  # noqa: PLR0912, PLR0913, PLR0915, PLR0917  # a kernel: one pass, plain arrays
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
    """The cost (a,) of each sampled velocity, +inf: it is not admissible, or cannot be the least.

    As no critic's cost is negative, a velocity is given up as soon as what it has cost is more than
    another costs that moves; the likely ones come first.

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
    out = np.full(targets.shape[0], np.inf)
    inputs, poses = np.empty((steps, targets.shape[1])), np.empty((steps + 1, 3))
    contact, needed = np.empty(discs.shape[0]), np.empty(people.shape[0])
    around = 0.0  # radius about the pose that holds all of the robot
    for j in range(discs.shape[0]):
        contact[j] = min(margins[0], wall_gap(discs[j], start, distance, resolution, X_MG) - 1e-6)
        around = max(around, math.hypot(discs[j, 0], discs[j, 1]) + discs[j, 2])
    for i in range(people.shape[0]):
        gap = _to_body(capsule, start, people[i, 0], radius[i])
        needed[i] = min(margins[1], gap - _CLOSER)
    # farther than this nothing touches, and no critic counts it
    off_walls = around + max(margins[0], margins[2]) + 2.0 * resolution
    off_people = around + max(margins[1], margins[2]) + _SAFE
    room = sample(distance, resolution, X_MG, start[0], start[1])[0] - off_walls
    goal = path[path.shape[0] - 1]
    held = min(max(round(braking[0] / step), 1), steps)
    change = np.abs(targets - last).sum(axis=1)
    bound = np.inf
    for a in np.argsort(change):
        ramp(targets[a], now, rise, fall, inputs)
        drive(start, inputs, twists, step, poses)
        speed = (
            math.hypot(poses[held, 0] - poses[held - 1, 0], poses[held, 1] - poses[held - 1, 1])
            / step
        )
        turn = abs(poses[held, 2] - poses[held - 1, 2]) / step
        way, angle, crowd, free = 0.0, 0.0, 0.0, room
        safe, driven = True, steps + 1
        for k in range(1, steps + 1):
            moved = math.hypot(poses[k, 0] - poses[k - 1, 0], poses[k, 1] - poses[k - 1, 1])
            turned = abs(poses[k, 2] - poses[k - 1, 2])
            if k > held:
                way, angle = way + moved, angle + turned
            nearest, touches = np.inf, False
            free -= moved
            if free <= 0.0:
                free = sample(distance, resolution, X_MG, poses[k, 0], poses[k, 1])[0] - off_walls
            for j in range(discs.shape[0] if free <= 0.0 else 0):
                gap = wall_gap(discs[j], poses[k], distance, resolution, X_MG)
                nearest = min(nearest, gap)
                touches |= gap < contact[j]
            if touches:
                # Fox et al., eq. (14): v ≤ √(2 · dist · braking), for turns likewise
                far = way >= 0.5 * speed * speed / braking[1]
                safe = far and (speed > STANDING or angle >= 0.5 * turn * turn / braking[2])
            for i in range(people.shape[0]):
                dx, dy = people[i, k, 0] - poses[k, 0], people[i, k, 1] - poses[k, 1]
                if dx * dx + dy * dy > (off_people + radius[i]) ** 2:
                    continue
                gap = _to_body(capsule, poses[k], people[i, k], radius[i])
                nearest = min(nearest, gap)
                if gap < needed[i] and moved + turned > STANDING * step:
                    touches = True
                    safe &= k * step >= braking[0] + speed / braking[1]
            short = max(1.0 - max(nearest, 0.0) / margins[2], 0.0)
            crowd += short * short
            if touches:
                crowd += steps - k
                driven = k
                break
        if not safe:
            continue
        end = poses[min(driven, steps)]
        x = end[0] + weights[6] * math.cos(end[2])
        y = end[1] + weights[6] * math.sin(end[2])
        aside = math.hypot(x - goal[0], y - goal[1])
        spent = weights[3] * aside + weights[4] * crowd / steps + weights[5] * change[a]
        if spent > bound:
            continue
        left = abs(beside(path, end[0], end[1])[1] - weights[6])
        if spent + weights[2] * left > bound:
            continue
        off, points = 0.0, 0
        for k in range(1, driven):
            if k % _EVERY == 0 or k == steps:
                off += beside(path, poses[k, 0], poses[k, 1])[0]
                points += 1
        out[a] = (
            weights[0] * off / max(points, 1)
            + weights[1] * beside(path, x, y)[0]
            + weights[2] * left
            + weights[3] * aside
            + weights[4] * crowd / steps
            + weights[5] * change[a]
        )
        if np.abs(targets[a]).max() > AT_REST:
            bound = min(bound, out[a] + _TIE)
    return out


@njit(cache=True, inline="always")
def _to_body(capsule: Floats, pose: Floats, body: Floats, radius: float) -> float:
    gap: float = nearest_on_spine(capsule, pose, body[0], body[1])[0] - capsule[4] - radius
    return gap
