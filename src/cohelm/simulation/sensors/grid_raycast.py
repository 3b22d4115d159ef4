"""Exact ray casting in an occupancy grid, cell by cell (Amanatides and Woo 1987), and on discs."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.kernels import CACHED, callee


@njit(**CACHED)
def cast(
    occupied: Booleans,
    resolution: float,
    X_MG: Floats,
    discs: Floats,
    pose: Floats,
    angles: Floats,
    range_max: float,
) -> Floats:
    """Distance of the first occupied cell or disc on each ray.

    Args:
        occupied: (rows, cols) reflecting cells; the outside of the grid does not reflect.
        resolution: side of a cell, m.
        X_MG: (3,) the grid in the map frame.
        discs: (n, 3) as (x, y, radius) in the map frame, m.
        pose: (3,) of the sensor in the map frame.
        angles: (b,) directions in the sensor's frame, rad.
        range_max: m.

    Returns:
        (b,) m; +inf without a hit within ``range_max``; 0 for a sensor inside an obstacle.
    """
    out = np.full(angles.shape[0], np.inf)
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    ox, oy = pose[0] - X_MG[0], pose[1] - X_MG[1]
    x, y = (cos * ox + sin * oy) / resolution, (-sin * ox + cos * oy) / resolution
    near = _within_range(discs, pose, range_max)
    for b in range(angles.shape[0]):
        direction = pose[2] + angles[b]
        dx, dy = math.cos(direction), math.sin(direction)
        gx, gy = dx, dy
        if X_MG[2] != 0.0:
            gx, gy = math.cos(direction - X_MG[2]), math.sin(direction - X_MG[2])
        distance = _to_cell(occupied, x, y, gx, gy, range_max / resolution) * resolution
        for k in range(near.shape[0]):
            distance = min(distance, _to_disc(near[k], dx, dy))
        if distance <= range_max:
            out[b] = distance
    return out


@njit(**CACHED)
def in_sight(
    occupied: Booleans, resolution: float, X_MG: Floats, start: Floats, end: Floats
) -> Booleans:
    """Mask (n,) of free straight lines from ``start`` (n, 2) to ``end`` (n, 2).

    The other arguments are those of :func:`cast`.
    """
    out = np.empty(start.shape[0], dtype=np.bool_)
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    for i in range(start.shape[0]):
        ox, oy = start[i, 0] - X_MG[0], start[i, 1] - X_MG[1]
        x, y = (cos * ox + sin * oy) / resolution, (-sin * ox + cos * oy) / resolution
        dx, dy = end[i, 0] - start[i, 0], end[i, 1] - start[i, 1]
        far = math.hypot(dx, dy)
        angle = math.atan2(dy, dx) - X_MG[2]
        reach = far / resolution
        out[i] = _to_cell(occupied, x, y, math.cos(angle), math.sin(angle), reach) > reach
    return out


@callee()
def _within_range(discs: Floats, pose: Floats, reach: float) -> Floats:
    """Discs that rays can meet, relative to the sensor's position."""
    out = np.empty_like(discs)
    count = 0
    for k in range(discs.shape[0]):
        dx, dy = discs[k, 0] - pose[0], discs[k, 1] - pose[1]
        if math.hypot(dx, dy) - discs[k, 2] <= reach:
            out[count, 0], out[count, 1], out[count, 2] = dx, dy, discs[k, 2]
            count += 1
    return out[:count]


@callee()
def _to_disc(disc: Floats, dx: float, dy: float) -> float:
    """Distance to a disc along a ray from the origin in unit direction (dx, dy); inf: no hit."""
    along = disc[0] * dx + disc[1] * dy
    inside = disc[2] * disc[2] - disc[0] * disc[0] - disc[1] * disc[1]
    if inside >= 0.0:
        return 0.0
    chord = inside + along * along
    if along <= 0.0 or chord < 0.0:
        return np.inf
    distance: float = along - math.sqrt(chord)
    return distance


@callee()
def _to_cell(occupied: Booleans, x: float, y: float, dx: float, dy: float, reach: float) -> float:
    """Distance, in cells, to an occupied cell from (x, y) along the unit direction (dx, dy)."""
    # Clip the ray to the grid.
    rows, cols = occupied.shape
    t, leave = span(x, dx, cols, 0.0, reach)
    t, leave = span(y, dy, rows, t, leave)
    if t > leave:
        return np.inf
    c = min(max(math.floor(x + t * dx), 0), cols - 1)
    r = min(max(math.floor(y + t * dy), 0), rows - 1)
    step_c, next_c, per_c = stride(x, dx, c)
    step_r, next_r, per_r = stride(y, dy, r)
    # Step to the neighbour across the nearer border until a cell is occupied.
    while True:
        if occupied[r, c]:
            return t
        if next_c < next_r:
            t, c, next_c = next_c, c + step_c, next_c + per_c
        else:
            t, r, next_r = next_r, r + step_r, next_r + per_r
        if t > leave or not (0 <= c < cols and 0 <= r < rows):
            return np.inf


@njit(**CACHED, inline="always")
def span(at: float, slope: float, size: float, enter: float, leave: float) -> tuple[float, float]:
    """Part of [enter, leave] in which a coordinate lies within [0, size]."""
    if slope == 0.0:
        return (enter, leave) if 0.0 <= at < size else (np.inf, leave)
    a, b = -at / slope, (size - at) / slope
    return max(enter, min(a, b)), min(leave, max(a, b))


@njit(**CACHED, inline="always")
def stride(at: float, slope: float, cell: int) -> tuple[int, float, float]:
    """Step, ray parameter of the first border, and parameter between borders of one axis."""
    if slope > 0.0:
        return 1, (cell + 1 - at) / slope, 1.0 / slope
    if slope < 0.0:
        return -1, (cell - at) / slope, -1.0 / slope
    return 0, np.inf, np.inf
