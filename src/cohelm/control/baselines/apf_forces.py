"""The forces of a potential field on a robot's footprint: attraction, walls, people."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.control.baselines.steering import stepped, twist_toward
from cohelm.maps.distance import sample
from cohelm.robots.contact import nearest_on_spine

_LEAST = 0.05
"""Gaps below this repel like this one, m: the force stays finite."""


@njit(cache=True)
def repulsion(gap: float, reach: float, strength: float) -> float:
    """Khatib's force of an obstacle, η (1/ρ − 1/ρ₀) / ρ² within ρ₀, without unit.

    gap: ρ, m.  reach: ρ₀, m.  strength: η, m³.
    """
    if gap >= reach:
        return 0.0
    rho = max(gap, _LEAST)
    return max(strength * (1.0 / rho - 1.0 / reach) / (rho * rho), 0.0)


@njit(cache=True)
def people_force(
    pose: Floats,
    capsule: Floats,
    positions: Floats,
    radius: Floats,
    reach: float,
    strength: float,
) -> tuple[float, float]:
    """The sum over people (n, 2) of their repulsion, away from each; map frame."""
    x, y = 0.0, 0.0
    for i in range(positions.shape[0]):
        d, nx, ny, _, _, _ = nearest_on_spine(capsule, pose, positions[i, 0], positions[i, 1])
        size = repulsion(d - capsule[4] - radius[i], reach, strength)
        x -= size * nx
        y -= size * ny
    return x, y


@njit(cache=True)
def walls_force(  # noqa: PLR0917  # a kernel takes plain arrays
    pose: Floats,
    discs: Floats,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    reach: float,
    strength: float,
) -> tuple[float, float]:
    """The mean over the discs (c, 3) of the walls' repulsion, along the field's gradient."""
    x, y = 0.0, 0.0
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for j in range(discs.shape[0]):
        px = pose[0] + cos * discs[j, 0] - sin * discs[j, 1]
        py = pose[1] + sin * discs[j, 0] + cos * discs[j, 1]
        d, gx, gy = sample(distance, resolution, X_MG, px, py)
        size = repulsion(d - discs[j, 2], reach, strength) / discs.shape[0]
        x += size * gx
        y += size * gy
    return x, y


@njit(cache=True)
def descend(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    start: Floats,
    now: Floats,
    goals: Floats,
    wanted: Floats,
    hand: Floats,
    eta: float,
    capsule: Floats,
    discs: Floats,
    positions: Floats,
    radius: Floats,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    field: Floats,
    to_input: Floats,
    to_twist: Floats,
    bounds: Floats,
    sideways: bool,
    gain: float,
    step: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """(poses (N+1, 3), inputs (N, m), forces now (4, 2), target twist now (3,)) down the field.

    Forces are those of the path, the rider, walls and people. Where their sum pushes back, the
    robot does not turn round: it steers to the side that the sum leans to, and stands or, where
    that is allowed, backs off.

    goals: (N, 2) attracting points.  wanted: (N,) speeds.  hand: (2,) the stick, forward and left.
    field: (reach and strength of people, of walls).
    """
    steps, m = goals.shape[0], now.shape[0]
    poses, inputs = np.empty((steps + 1, 3)), np.empty((steps, m))
    first, target = np.zeros((4, 2)), np.zeros(3)
    pose, u = start.copy(), now.copy()
    poses[0] = start
    for k in range(steps):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        dx, dy = goals[k, 0] - pose[0], goals[k, 1] - pose[1]
        away = max(math.sqrt(dx * dx + dy * dy), 1e-9)
        ax, ay = (1.0 - eta) * dx / away, (1.0 - eta) * dy / away
        hx = eta * (cos * hand[0] - sin * hand[1])
        hy = eta * (sin * hand[0] + cos * hand[1])
        px, py = people_force(pose, capsule, positions, radius, field[0], field[1])
        wx, wy = walls_force(pose, discs, distance, resolution, X_MG, field[2], field[3])
        fx, fy = ax + hx + px + wx, ay + hy + py + wy
        ahead, aside = cos * fx + sin * fy, -sin * fx + cos * fy
        pulled = cos * (ax + hx) + sin * (ay + hy)
        speed = wanted[k] * min(math.sqrt(fx * fx + fy * fy), 1.0)
        if ahead < 0.0 and pulled > 0.0 and not sideways:
            vx, vy = speed * min(ahead, 0.0), 0.0
            w = gain * math.atan2(aside, -ahead)
        else:
            vx, vy, w = twist_toward(math.atan2(aside, ahead), speed, gain, sideways)
        if k == 0:
            first[0], first[1] = (ax, ay), (hx, hy)
            first[2], first[3] = (wx, wy), (px, py)
            target[:] = (max(vx, bounds[0, 0]), vy, w)
        change = step if k > 0 else 0.5 * step
        stepped(pose, u, vx, vy, w, to_input, to_twist, bounds, step, change)
        poses[k + 1] = pose
        inputs[k] = u
    return poses, inputs, first, target
