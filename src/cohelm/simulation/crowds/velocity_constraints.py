"""Velocity constraints of pedestrians: ORCA's half-planes, and freedom from contact in one step.

The linear programs are those of van den Berg et al. 2011, §5. A half-plane is a row (p_x, p_y, d_x,
d_y): a point on its border and the unit direction of the border; the left of the direction is
allowed. The programs visit the half-planes in the given order, so that with the same order they
give the result of the RVO2 library.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np
from numba import njit

from cohelm.array_kernels import copy_row, stable_order
from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED, callee
from cohelm.simulation.wall_geometry import SurfaceCells, free_region, near_cells, to_grid_frame

_PARALLEL = 1e-5
"""Cross product of two directions below which they count as parallel, as in RVO2."""
_NEAR = cast("bool", np.bool_(False))
_ALONG = cast("bool", np.bool_(True))
"""Goals of :func:`_nearest`; plain constants would be types of their own, each compiled."""


@njit(**CACHED)
def best_velocity(
    planes: Floats, hard: int, max_speed: float, preferred_x: float, preferred_y: float
) -> tuple[float, float]:
    """Find the velocity nearest to the preferred one within all half-planes and the speed limit.

    If there is none, the maximum violation of the half-planes after the first ``hard`` ones is
    minimised, and the first ones still hold.

    Args:
        planes: (k, 4), hard ones first.
        hard: number of half-planes that never yield.
        max_speed: m/s.
        preferred_x, preferred_y: m/s.

    Returns:
        (v_x, v_y), m/s.
    """
    failed, x, y = _nearest(planes, planes.shape[0], max_speed, preferred_x, preferred_y, _NEAR)
    if failed < planes.shape[0]:
        x, y = _least_violation(planes, hard, failed, max_speed, x, y)
    return x, y


@callee()
def _nearest(
    planes: Floats, count: int, max_speed: float, x: float, y: float, along: bool
) -> tuple[int, float, float]:
    """Two-dimensional program over ``planes[:count]``.

    ``along``: go as far as possible in the unit direction (x, y); else as near as possible to
    (x, y). Returns the index of the first half-plane that cannot be kept (``count`` where all are),
    and the best velocity under those before it.
    """
    if along:
        vx, vy = x * max_speed, y * max_speed
    elif x * x + y * y > max_speed * max_speed:
        norm = math.hypot(x, y)
        vx, vy = x / norm * max_speed, y / norm * max_speed
    else:
        vx, vy = x, y
    for i in range(count):
        px, py, dx, dy = planes[i]
        if dx * (py - vy) - dy * (px - vx) > 0.0:
            possible, t = _on_border(planes, i, max_speed, x, y, along)
            if not possible:
                return i, vx, vy
            vx, vy = px + t * dx, py + t * dy
    return count, vx, vy


@callee()
def _on_border(
    planes: Floats, i: int, max_speed: float, x: float, y: float, along: bool
) -> tuple[bool, float]:
    """One-dimensional program on the border of half-plane ``i``, under those before it."""
    px, py, dx, dy = planes[i]
    dot = px * dx + py * dy
    discriminant = dot * dot + max_speed * max_speed - (px * px + py * py)
    if discriminant < 0.0:
        return False, 0.0
    root = math.sqrt(discriminant)
    low, high = -dot - root, -dot + root
    for j in range(i):
        qx, qy, ex, ey = planes[j]
        slant = dx * ey - dy * ex
        offset = ex * (py - qy) - ey * (px - qx)
        if abs(slant) <= _PARALLEL:
            if offset < 0.0:
                return False, 0.0
            continue
        t = offset / slant
        if slant >= 0.0:
            high = min(high, t)
        else:
            low = max(low, t)
        if low > high:
            return False, 0.0
    if along:
        return True, high if x * dx + y * dy > 0.0 else low
    return True, min(max(dx * (x - px) + dy * (y - py), low), high)


@callee()
def _least_violation(
    planes: Floats, hard: int, begin: int, max_speed: float, vx: float, vy: float
) -> tuple[float, float]:
    """Three-dimensional program: the minimum depth by which the soft half-planes must yield."""
    depth = 0.0
    projected = np.empty_like(planes)
    for i in range(hard):
        copy_row(projected[i], planes[i])
    for i in range(begin, planes.shape[0]):
        px, py, dx, dy = planes[i]
        if dx * (py - vy) - dy * (px - vx) <= depth:
            continue
        count = hard
        for j in range(hard, i):
            qx, qy, ex, ey = planes[j]
            slant = dx * ey - dy * ex
            if abs(slant) <= _PARALLEL:
                if dx * ex + dy * ey > 0.0:
                    continue
                mx, my = 0.5 * (px + qx), 0.5 * (py + qy)
            else:
                t = (ex * (py - qy) - ey * (px - qx)) / slant
                mx, my = px + t * dx, py + t * dy
            norm = math.hypot(ex - dx, ey - dy)
            projected[count, 0], projected[count, 1] = mx, my
            projected[count, 2], projected[count, 3] = (ex - dx) / norm, (ey - dy) / norm
            count += 1
        failed, x, y = _nearest(projected, count, max_speed, -dy, dx, _ALONG)
        if failed >= count:
            vx, vy = x, y
        depth = dx * (py - vy) - dy * (px - vx)
    return vx, vy


PARTING_SPEED = 0.5
"""Maximum speed at which overlapping bodies part, m/s."""


@njit(**CACHED)
def orca_velocities(
    position: Floats,
    velocity: Floats,
    radius: Floats,
    body: Floats,
    desired: Floats,
    max_speed: Floats,
    sees_robot: Booleans,
    walls: SurfaceCells,
    neighbor_dist: float,
    max_neighbors: int,
    horizon: float,
    wall_horizon: float,
    robot_share: float,
    robot_headway: float,
    dt: float,
) -> Floats:
    """Compute the velocities (n, 2) of n people; further rows of the first arrays: the robot.

    People would also like to leave the robot the distance that it approaches in ``robot_headway``,
    s. This changes the desired velocity only, so that walls and bodies come first.
    """
    n = desired.shape[0]
    out = np.empty((n, 2))
    for i in range(n):
        # Walls are hard constraints, other people soft ones.
        extent = body[i] + max_speed[i] * wall_horizon + 2.0 * walls.half
        fixed = wall_planes(walls, position[i], body[i], extent, wall_horizon)
        others = _neighbours(position, n, i, sees_robot[i], neighbor_dist, max_neighbors)
        hard = fixed.shape[0]
        planes = np.empty((hard + others.shape[0], 4))
        wx, wy = desired[i]
        for k in range(hard):
            copy_row(planes[k], fixed[k])
        for k in range(others.shape[0]):
            j = others[k]
            share = robot_share if j >= n else 0.5
            px, py, dx, dy = _orca_plane(position, velocity, radius, i, j, 0.0, horizon, dt, share)
            planes[hard + k, 0], planes[hard + k, 1] = px, py
            planes[hard + k, 2], planes[hard + k, 3] = dx, dy
            margin = _margin(position, velocity, radius, i, j, robot_headway) if j >= n else 0.0
            if margin > 0.0:
                px, py, dx, dy = _orca_plane(
                    position, velocity, radius, i, j, margin, horizon, dt, 1.0
                )
                lack = max(dx * (py - wy) - dy * (px - wx), 0.0)
                wx, wy = wx - lack * dy, wy + lack * dx
        vx, vy = best_velocity(planes, hard, max_speed[i], wx, wy)
        # Rounding must not lead through a wall.
        keep = allowed_share(fixed, vx, vy)
        out[i, 0], out[i, 1] = keep * vx, keep * vy
    return out


@callee()
def _neighbours(
    position: Floats, n: int, i: int, sees_robot: bool, distance: float, limit: int
) -> Integers:
    """Find the ``limit`` nearest others within a distance; rows from ``n`` on are the robot."""
    found = np.empty(limit, dtype=np.int64)
    near = np.empty(limit)
    count = 0
    farthest = distance * distance
    for j in range(position.shape[0]):
        if j == i or (j >= n and not sees_robot) or limit == 0:
            continue
        dx, dy = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
        d2 = dx * dx + dy * dy
        if d2 >= farthest:
            continue
        if count < limit:
            count += 1
        k = count - 1
        while k > 0 and d2 < near[k - 1]:
            near[k], found[k] = near[k - 1], found[k - 1]
            k -= 1
        near[k], found[k] = d2, j
        if count == limit:
            farthest = near[count - 1]
    return found[:count]


@callee()
def _margin(
    position: Floats, velocity: Floats, radius: Floats, i: int, j: int, headway: float
) -> float:
    """Distance that ``j`` approaches ``i`` in ``headway``, at most half of the gap, m."""
    px, py = position[i, 0] - position[j, 0], position[i, 1] - position[j, 1]
    distance = math.hypot(px, py)
    gap: float = distance - radius[i] - radius[j]
    if gap <= 0.0:
        return 0.0
    approach: float = (velocity[j, 0] * px + velocity[j, 1] * py) / distance
    return min(headway * approach, 0.5 * gap)


@callee()
def _orca_plane(
    position: Floats,
    velocity: Floats,
    radius: Floats,
    i: int,
    j: int,
    margin: float,
    horizon: float,
    dt: float,
    share: float,
) -> tuple[float, float, float, float]:
    """Half-plane of velocities of ``i`` induced by ``j``; van den Berg et al., eq. (4)–(6).

    u is the smallest change of the relative velocity that leaves the velocity obstacle, truncated
    at the horizon; ``i`` takes ``share`` of it. Overlapping bodies must part within ``dt``.
    """
    px, py = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
    vx, vy = velocity[i, 0] - velocity[j, 0], velocity[i, 1] - velocity[j, 1]
    d2 = px * px + py * py
    r = radius[i] + radius[j] + margin
    apart = d2 > r * r
    rate = 1.0 / horizon if apart else 1.0 / dt
    wx, wy = vx - rate * px, vy - rate * py
    w2 = wx * wx + wy * wy
    dot = wx * px + wy * py
    if not apart or (dot < 0.0 and dot * dot > r * r * w2):
        # The cut-off circle is nearest.
        w = math.sqrt(w2)
        nx, ny = (wx / w, wy / w) if w > 0.0 else (-1.0, 0.0)
        dx, dy = ny, -nx
        ux, uy = (r * rate - w) * nx, (r * rate - w) * ny
    else:
        # A leg of the cone is nearest.
        leg = math.sqrt(d2 - r * r)
        if px * wy - py * wx > 0.0:
            dx, dy = (px * leg - py * r) / d2, (px * r + py * leg) / d2
        else:
            dx, dy = -(px * leg + py * r) / d2, -(-px * r + py * leg) / d2
        along = vx * dx + vy * dy
        ux, uy = along * dx - vx, along * dy - vy
    return velocity[i, 0] + share * ux, velocity[i, 1] + share * uy, dx, dy


@callee()
def wall_planes(
    walls: SurfaceCells,
    position: Floats,
    body: float,
    distance: float,
    horizon: float,
) -> Floats:
    """Hard half-planes (k, 4): v·u ≤ max(d − body, 0) / horizon towards walls within a distance.

    d is the distance to the wall. Standing still is always allowed.
    """
    x, y = to_grid_frame(walls, position[0], position[1])
    region = free_region(near_cells(walls, x, y, distance), walls.half, x, y)
    cos, sin = math.cos(walls.X_MG[2]), math.sin(walls.X_MG[2])
    out = np.empty((region.shape[0], 4))
    for k in range(region.shape[0]):
        ux = cos * region[k, 0] - sin * region[k, 1]
        uy = sin * region[k, 0] + cos * region[k, 1]
        speed = max(region[k, 2] - body, 0.0) / horizon
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = speed * ux, speed * uy, -uy, ux
    return out


@callee()
def allowed_share(planes: Floats, vx: float, vy: float) -> float:
    """Share of a velocity that half-planes about 0 allow; 1 except for rounding."""
    keep = 1.0
    for k in range(planes.shape[0]):
        px, py, dx, dy = planes[k]
        towards = vx * dy - vy * dx
        allowed = max(px * dy - py * dx, 0.0)
        if towards > allowed:
            keep = min(keep, allowed / towards)
    return keep


@njit(**CACHED)
def without_contact(
    position: Floats,
    velocity: Floats,
    radius: Floats,
    desired: Floats,
    max_speed: Floats,
    sees_robot: Booleans,
    walls: SurfaceCells,
    dt: float,
) -> Floats:
    """Velocities (n, 2) nearest to the desired ones without overlap of bodies after ``dt``.

    Towards another v·u ≤ gap / 2dt, towards the robot v·u ≤ gap / dt + its own velocity along u,
    towards a wall v·u ≤ gap / dt: half-planes, of which those of walls are hard. Each person
    closes at most their share of a gap. Overlapping bodies part at up to ``PARTING_SPEED``.

    Args:
        position, velocity, radius: (n + 1, 2), (n + 1, 2), (n + 1,); the last is the robot.
        desired: (n, 2), m/s.
        max_speed: (n,), m/s.
        sees_robot: (n,); False: the robot is ignored.
        walls: surface cells of the grid.
        dt: s.
    """
    n = desired.shape[0]
    out = np.empty((n, 2))
    order = stable_order(position[:, 0].copy())
    fastest = max(np.max(max_speed) if n > 0 else 0.0, math.hypot(velocity[n, 0], velocity[n, 1]))
    widest = np.max(radius) if n > 0 else 0.0
    for a in range(n + 1):
        i = order[a]
        if i == n:
            continue
        extent = radius[i] + max_speed[i] * dt + 2.0 * walls.half
        fixed = wall_planes(walls, position[i], radius[i], extent, dt)
        hard, count = fixed.shape[0], fixed.shape[0]
        # Candidates are contiguous in the order of x.
        reach = radius[i] + widest + 2.0 * fastest * dt
        low, high = a, a + 1
        while low > 0 and position[i, 0] - position[order[low - 1], 0] <= reach:
            low -= 1
        while high <= n and position[order[high], 0] - position[i, 0] <= reach:
            high += 1
        planes = np.empty((hard + high - low, 4))
        for k in range(hard):
            copy_row(planes[k], fixed[k])
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
                speed = max(gap / dt, -PARTING_SPEED) + velocity[n, 0] * ux + velocity[n, 1] * uy
            else:
                speed = max(0.5 * gap / dt, -PARTING_SPEED)
            planes[count, 0], planes[count, 1] = speed * ux, speed * uy
            planes[count, 2], planes[count, 3] = -uy, ux
            count += 1
        vx, vy = best_velocity(planes[:count], hard, max_speed[i], desired[i, 0], desired[i, 1])
        keep = allowed_share(fixed, vx, vy)
        out[i, 0], out[i, 1] = keep * vx, keep * vy
    return out
