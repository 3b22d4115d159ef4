"""Social costs of rollouts: asymmetric Gaussians about people, and early passing."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.baselines.steering import wrapped
from cohelm.kernels import CACHED
from cohelm.maps.distance import sample
from cohelm.robots.capsule import nearest_on_spine_in_map
from cohelm.robots.wall_contact import WallGrid, wall_gap

_SLOW = 0.05
"""A person slower than this stands, m/s: front and rear are equal."""
_UNEVEN = 4.0
"""Cells by which a distance field may decrease more than its argument moves."""


@njit(**CACHED)
def social_cost(
    poses: Floats,
    capsule: Floats,
    positions: Floats,
    velocities: Floats,
    weights: Floats,
    radius: Floats,
    sigma: Floats,
) -> Floats:
    """Mean over the steps of Σ_i Σ_h w exp(−q) of rollouts (r, N+1, 3), (r,).

    q = g² (cos²δ / 2σ² + sin²δ / 2σ_s²) with g the gap between footprint and body, δ its direction
    from the person's motion, σ = σ_h where cos δ > 0, else σ_r; ``sigma`` is (σ_h, σ_s, σ_r, σ of
    standing people). Poddar et al. take a mean over people; a sum counts each
    person in full, also in a crowd.

    positions, velocities: (n, h, N+1, 2) at least.  weights: (n, h).  radius: (n,).
    """
    count, steps = poses.shape[0], poses.shape[1] - 1
    out = np.zeros(count)
    for r in range(count):
        for k in range(1, steps + 1):
            for i in range(positions.shape[0]):
                for h in range(positions.shape[1]):
                    d, nx, ny, _, _, _ = nearest_on_spine_in_map(
                        capsule, poses[r, k], positions[i, h, k, 0], positions[i, h, k, 1]
                    )
                    gap = max(d - capsule[4] - radius[i], 0.0)
                    vx, vy = velocities[i, h, k, 0], velocities[i, h, k, 1]
                    speed = math.sqrt(vx * vx + vy * vy)
                    if speed < _SLOW:
                        q = 0.5 * gap * gap / (sigma[3] * sigma[3])
                    else:
                        cos, sin = -(nx * vx + ny * vy) / speed, (nx * vy - ny * vx) / speed
                        along = sigma[0] if cos > 0.0 else sigma[2]
                        q = 0.5 * gap * gap * ((cos / along) ** 2 + (sin / sigma[1]) ** 2)
                    out[r] += weights[i, h] * math.exp(-q) / steps
    return out


@njit(**CACHED)
def passing(poses: Floats, positions: Floats, velocities: Floats, weights: Floats) -> Floats:
    """Speed at which rollouts (r, N+1, 3) pass the people in front of them, rad per step, (r,).

    The mean over people of |mean change of the direction person → robot|: high if a side is
    chosen early (topological invariance; Mavrogiannis et al., 2022).
    """
    count, steps = poses.shape[0], poses.shape[1] - 1
    people, hypotheses = positions.shape[0], positions.shape[1]
    out = np.zeros(count)
    for r in range(count):
        for i in range(people):
            for h in range(hypotheses):
                dx = poses[r, 0, 0] - positions[i, h, 0, 0]
                dy = poses[r, 0, 1] - positions[i, h, 0, 1]
                if dx * velocities[i, h, 0, 0] + dy * velocities[i, h, 0, 1] <= 0.0:
                    continue
                before, total = math.atan2(dy, dx), 0.0
                for k in range(1, steps + 1):
                    dx = poses[r, k, 0] - positions[i, h, k, 0]
                    dy = poses[r, k, 1] - positions[i, h, k, 1]
                    angle = math.atan2(dy, dx)
                    total += wrapped(angle - before)
                    before = angle
                out[r] += weights[i, h] * abs(total) / (steps * people)
    return out


@njit(**CACHED)
def wall_gaps(poses: Floats, discs: Floats, walls: WallGrid) -> tuple[Floats, float]:
    """(smallest gap to a wall along each rollout (r, N+1, 3), (r,); the gap at the start), m."""
    out = np.full(poses.shape[0], np.inf)
    last, at = np.empty(discs.shape[0]), np.empty((discs.shape[0], 2))
    for r in range(poses.shape[0]):
        for k in range(poses.shape[1]):
            cos, sin = math.cos(poses[r, k, 2]), math.sin(poses[r, k, 2])
            for j in range(discs.shape[0]):
                x = poses[r, k, 0] + cos * discs[j, 0] - sin * discs[j, 1]
                y = poses[r, k, 1] + sin * discs[j, 0] + cos * discs[j, 1]
                # a gap shrinks by no more than the motion of its disc since it was sampled
                if k > 0:
                    moved = math.sqrt((x - at[j, 0]) ** 2 + (y - at[j, 1]) ** 2)
                    if last[j] - moved - _UNEVEN * walls.resolution > out[r]:
                        continue
                gap = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0] - discs[j, 2]
                last[j], at[j, 0], at[j, 1] = gap, x, y
                if k > 0:
                    out[r] = min(out[r], gap)
    initial_gap = np.inf
    for j in range(discs.shape[0]):
        initial_gap = min(initial_gap, wall_gap(discs[j], poses[0, 0], walls))
    return out, initial_gap


@njit(**CACHED)
def nearest_squared(poses: Floats, path: Floats) -> Floats:
    """Squared distance from the positions of rollouts (r, N+1, 3) to the nearest pose of a path.

    path: (k, 3).  Returns (r, N), m², without the first position.
    """
    count, steps = poses.shape[0], poses.shape[1] - 1
    out = np.full((count, steps), np.inf)
    for r in range(count):
        for k in range(steps):
            for i in range(path.shape[0]):
                dx, dy = poses[r, k + 1, 0] - path[i, 0], poses[r, k + 1, 1] - path[i, 1]
                out[r, k] = min(out[r, k], dx * dx + dy * dy)
    return out
