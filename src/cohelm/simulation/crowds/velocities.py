"""The kernel of ORCA: what neighbours and walls leave each person to choose from, and the best."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.simulation.crowds.half_planes import best_velocity
from cohelm.simulation.walls import free_region, near_cells


@njit(cache=True)
def velocities(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
    position: Floats,
    velocity: Floats,
    radius: Floats,
    body: Floats,
    wanted: Floats,
    max_speed: Floats,
    sees_robot: Booleans,
    cells: Floats,
    start: Integers,
    tiles: Integers,
    half: float,
    X_MG: Floats,
    neighbor_dist: float,
    max_neighbors: int,
    horizon: float,
    horizon_walls: float,
    robot_share: float,
    dt: float,
) -> Floats:
    """Velocities (n, 2) of the n people; row n of the first three arrays is the robot."""
    n = wanted.shape[0]
    out = np.empty((n, 2))
    for i in range(n):
        reach = body[i] + max_speed[i] * horizon_walls + 2.0 * half
        walls = wall_planes(
            cells, start, tiles, half, X_MG, position[i], body[i], reach, horizon_walls
        )
        others = _neighbours(position, i, sees_robot[i], neighbor_dist, max_neighbors)
        hard = walls.shape[0]
        planes = np.empty((hard + others.shape[0], 4))
        planes[:hard] = walls
        for k in range(others.shape[0]):
            j = others[k]
            share = robot_share if j == n else 0.5
            planes[hard + k] = _plane(position, velocity, radius, i, j, horizon, dt, share)
        vx, vy = best_velocity(planes, hard, max_speed[i], wanted[i, 0], wanted[i, 1])
        keep = within(walls, vx, vy)
        out[i, 0], out[i, 1] = keep * vx, keep * vy
    return out


@njit(cache=True)
def _neighbours(position: Floats, i: int, sees_robot: bool, reach: float, most: int) -> Integers:
    """The ``most`` nearest others within ``reach``, nearest first; the last row is the robot."""
    m = position.shape[0]
    found = np.empty(most, dtype=np.int64)
    near = np.empty(most)
    count = 0
    limit = reach * reach
    for j in range(m):
        if j == i or (j == m - 1 and not sees_robot) or most == 0:
            continue
        dx, dy = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
        d2 = dx * dx + dy * dy
        if d2 >= limit:
            continue
        if count < most:
            count += 1
        k = count - 1
        while k > 0 and d2 < near[k - 1]:
            near[k], found[k] = near[k - 1], found[k - 1]
            k -= 1
        near[k], found[k] = d2, j
        if count == most:
            limit = near[count - 1]
    return found[:count]


@njit(cache=True)
def _plane(  # noqa: PLR0917  # a kernel takes arrays and scalars
    position: Floats,
    velocity: Floats,
    radius: Floats,
    i: int,
    j: int,
    horizon: float,
    dt: float,
    share: float,
) -> tuple[float, float, float, float]:
    """The half-plane of velocities of ``i`` induced by ``j``; van den Berg et al., eq. (4)–(6).

    u is the least change of the relative velocity that leaves the velocity obstacle, truncated at
    the horizon; ``i`` takes ``share`` of it on. Bodies that overlap must part within ``dt``.
    """
    px, py = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
    vx, vy = velocity[i, 0] - velocity[j, 0], velocity[i, 1] - velocity[j, 1]
    d2 = px * px + py * py
    r = radius[i] + radius[j]
    apart = d2 > r * r
    rate = 1.0 / horizon if apart else 1.0 / dt
    wx, wy = vx - rate * px, vy - rate * py
    w2 = wx * wx + wy * wy
    dot = wx * px + wy * py
    if not apart or (dot < 0.0 and dot * dot > r * r * w2):  # the cut-off circle is nearest
        w = math.sqrt(w2)
        nx, ny = (wx / w, wy / w) if w > 0.0 else (-1.0, 0.0)
        dx, dy = ny, -nx
        ux, uy = (r * rate - w) * nx, (r * rate - w) * ny
    else:  # a leg of the cone
        leg = math.sqrt(d2 - r * r)
        if px * wy - py * wx > 0.0:
            dx, dy = (px * leg - py * r) / d2, (px * r + py * leg) / d2
        else:
            dx, dy = -(px * leg + py * r) / d2, -(-px * r + py * leg) / d2
        along = vx * dx + vy * dy
        ux, uy = along * dx - vx, along * dy - vy
    return velocity[i, 0] + share * ux, velocity[i, 1] + share * uy, dx, dy


@njit(cache=True)
def wall_planes(  # noqa: PLR0913, PLR0917  # a kernel takes arrays and scalars
    cells: Floats,
    start: Integers,
    tiles: Integers,
    half: float,
    X_MG: Floats,
    position: Floats,
    body: float,
    reach: float,
    horizon: float,
) -> Floats:
    """Hard half-planes (k, 4): v·u ≤ max(distance − body, 0) / horizon towards each wall.

    Standing still is always among what they allow.
    """
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    ox, oy = position[0] - X_MG[0], position[1] - X_MG[1]
    x, y = cos * ox + sin * oy, -sin * ox + cos * oy
    region = free_region(near_cells(cells, start, tiles, half, x, y, reach), half, x, y)
    out = np.empty((region.shape[0], 4))
    for k in range(region.shape[0]):
        ux = cos * region[k, 0] - sin * region[k, 1]
        uy = sin * region[k, 0] + cos * region[k, 1]
        speed = max(region[k, 2] - body, 0.0) / horizon
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = speed * ux, speed * uy, -uy, ux
    return out


@njit(cache=True)
def within(planes: Floats, vx: float, vy: float) -> float:
    """The share of a velocity that half-planes about 0 allow; 1 but for rounding."""
    keep = 1.0
    for k in range(planes.shape[0]):
        px, py, dx, dy = planes[k]
        towards = vx * dy - vy * dx
        allowed = max(px * dy - py * dx, 0.0)
        if towards > allowed:
            keep = min(keep, allowed / towards)
    return keep
