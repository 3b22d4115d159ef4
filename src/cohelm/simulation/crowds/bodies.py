"""What bodies allow: nobody closes more than their share of a gap within one step."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.simulation.crowds.half_planes import best_velocity
from cohelm.simulation.crowds.velocities import wall_planes, within

PART = 0.5
"""At which bodies part that overlap, m/s at most."""


@njit(cache=True)
def without_contact(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
    position: Floats,
    velocity: Floats,
    radius: Floats,
    wanted: Floats,
    max_speed: Floats,
    sees_robot: Booleans,
    cells: Floats,
    start: Integers,
    tiles: Integers,
    half: float,
    X_MG: Floats,
    dt: float,
) -> Floats:
    """The velocities (n, 2) nearest to the wanted ones by which no two bodies overlap after ``dt``.

    Towards another v·u ≤ gap / 2dt, towards the robot v·u ≤ gap / dt + its own velocity along u,
    towards a wall v·u ≤ gap / dt: half-planes, and those of the walls are hard. Bodies that overlap
    part at up to ``PART``.

    Args:
        position, velocity, radius: (n + 1, 2), (n + 1, 2), (n + 1,); the last is the robot.
        wanted: (n, 2), m/s.
        max_speed: (n,), m/s.
        sees_robot: (n,); who does not walks into it.
        cells, start, tiles, half, X_MG: of ``Walls``.
        dt: s.
    """
    n = wanted.shape[0]
    out = np.empty((n, 2))
    order = np.argsort(position[:, 0], kind="mergesort")
    fastest = max(np.max(max_speed) if n > 0 else 0.0, math.hypot(velocity[n, 0], velocity[n, 1]))
    widest = np.max(radius) if n > 0 else 0.0
    for a in range(n + 1):
        i = order[a]
        if i == n:
            continue
        reach = radius[i] + max_speed[i] * dt + 2.0 * half
        walls = wall_planes(cells, start, tiles, half, X_MG, position[i], radius[i], reach, dt)
        hard, count = walls.shape[0], walls.shape[0]
        reach = radius[i] + widest + 2.0 * fastest * dt
        low, high = a, a + 1
        while low > 0 and position[i, 0] - position[order[low - 1], 0] <= reach:
            low -= 1
        while high <= n and position[order[high], 0] - position[i, 0] <= reach:
            high += 1
        planes = np.empty((hard + high - low, 4))
        planes[:hard] = walls
        for b in range(low, high):
            j = order[b]
            if j == i or (j == n and not sees_robot[i]):
                continue
            dx, dy = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            d = math.hypot(dx, dy)
            if d > reach or d == 0.0:
                continue
            ux, uy = dx / d, dy / d
            gap = d - radius[i] - radius[j]
            if j == n:
                speed = max(gap / dt, -PART) + velocity[n, 0] * ux + velocity[n, 1] * uy
            else:
                speed = max(0.5 * gap / dt, -PART)
            planes[count, 0], planes[count, 1] = speed * ux, speed * uy
            planes[count, 2], planes[count, 3] = -uy, ux
            count += 1
        vx, vy = best_velocity(planes[:count], hard, max_speed[i], wanted[i, 0], wanted[i, 1])
        keep = within(walls, vx, vy)
        out[i, 0], out[i, 1] = keep * vx, keep * vy
    return out
