"""Linear programs of ORCA: velocities under half-planes (van den Berg et al. 2011, §5).

A half-plane is a row (p_x, p_y, d_x, d_y): a point on its border and the unit direction of the
border; the left of the direction is allowed. The programs visit the half-planes in the given order,
so that with the same order they give the result of the RVO2 library.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np
from numba import njit

from cohelm.array_kernels import copy_row
from cohelm.arrays import Floats
from cohelm.kernels import CACHED

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


@njit(**CACHED)
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


@njit(**CACHED)
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


@njit(**CACHED)
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
