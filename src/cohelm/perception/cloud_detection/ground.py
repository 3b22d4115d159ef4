"""Height of the ground about a sensor: level, sloping, stepped, sparsely scanned or occluded.

The plane is divided into sectors and rings. Outwards from the robot, which stands on the ground,
the lowest returns of a cell are ground if a drivable slope leads to them from the previous ring;
higher ones stand on it, lower ones lie below a step. Between neighbours on a ring the lower one
wins. So a box or a kerb remains an obstacle, and a ramp does not become one.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.kernels import CACHED, callee

SECTORS = 120
"""Sectors of a full turn (3° each)."""
RING_WIDTH = 0.3
"""Width of a ring, m."""
_THICKNESS = 0.08
"""The ground is the mean of a cell's returns up to this height above the lowest one, m."""
_BESIDE = 6
"""Sectors on either side for the comparison of a cell with its neighbours."""
_GROUND, _BETWEEN, _GUESSED = 2, 1, 0
"""Source of a cell's height: its returns, its neighbours on both sides, or the previous ring."""


@njit(**CACHED)
def ground_heights(points: Floats, slope: float, tolerance: float, reach: float) -> Floats:
    """Compute the height of each point (p,) above the ground below it, m.

    Args:
        points: (p, 3), x and y from the sensor, z from the floor under the robot, m.
        slope: steepest ground, rise over run.
        tolerance: largest step of the ground, m.
        reach: upper bound of the points' distance, m.
    """
    n = points.shape[0]
    rings = int(reach / RING_WIDTH) + 2
    distance = np.empty(n)
    sector = np.empty(n)
    for i in range(n):
        x, y = points[i, 0], points[i, 1]
        distance[i] = math.sqrt(x * x + y * y)
        sector[i] = (math.atan2(y, x) / (2.0 * math.pi) + 0.5) * SECTORS
    first, order, tall = _sorted(points, distance, sector, rings, slope, tolerance)
    level = _ground_level(points, distance, first, order, tall, slope, tolerance, rings)
    out = np.empty(n)
    for i in range(n):
        out[i] = points[i, 2] - _interpolated(level, distance[i], sector[i])
    return out


@callee()
def _sorted(
    points: Floats, distance: Floats, sector: Floats, rings: int, slope: float, tolerance: float
) -> tuple[Integers, Integers, Integers]:
    """Sort points that are low enough to be ground by cell; count the higher ones of each cell."""
    n = points.shape[0]
    first = np.zeros(rings * SECTORS + 1, dtype=np.int64)
    tall = np.zeros(rings * SECTORS, dtype=np.int64)
    cell = np.empty(n, dtype=np.int64)
    for i in range(n):
        c = int(distance[i] / RING_WIDTH) * SECTORS + min(int(sector[i]), SECTORS - 1)
        most = 3.0 * tolerance + slope * distance[i]
        z = points[i, 2]
        cell[i] = -1
        if abs(z) <= most:
            cell[i] = c
            first[c + 1] += 1
        if z > 0.3 + most or (z > 0.3 and distance[i] < 3.0):
            tall[c] += 1
    for c in range(rings * SECTORS):
        first[c + 1] += first[c]
    order = np.empty(first[-1], dtype=np.int64)
    at = first[:-1].copy()
    for i in range(n):
        if cell[i] >= 0:
            order[at[cell[i]]] = i
            at[cell[i]] += 1
    return first, order, tall


@callee()
def _ground_level(
    points: Floats,
    distance: Floats,
    first: Integers,
    order: Integers,
    tall: Integers,
    slope: float,
    tolerance: float,
    rings: int,
) -> Floats:
    """Height of the ground (rings, SECTORS) in the middle of each cell."""
    last_z, last_r = np.zeros(SECTORS), np.zeros(SECTORS)
    level, at = np.zeros((rings, SECTORS)), np.zeros((rings, SECTORS))
    kind = np.zeros((rings, SECTORS), dtype=np.int64)
    for j in range(rings):
        middle = (j + 0.5) * RING_WIDTH
        z, r = np.full(SECTORS, np.nan), np.full(SECTORS, middle)
        for k in range(SECTORS):
            c = j * SECTORS + k
            if first[c + 1] > first[c]:
                # Under tall objects only a gentle slope is ground: feet must not become a ramp.
                reachable = tolerance + slope * max(middle - last_r[k], 0.0)
                if tall[c] > 0:
                    reachable = min(reachable, tolerance + 0.25 * slope * (middle - last_r[k]))
                members = order[first[c] : first[c + 1]]
                z[k], r[k] = _lowest(points, distance, members, last_z[k], reachable)
        _drop_raised(z, middle, slope, tolerance)
        for k in range(SECTORS):
            if math.isnan(z[k]):
                continue
            level[j, k], at[j, k], kind[j, k] = z[k], r[k], _GROUND
            last_z[k], last_r[k] = z[k], r[k]
        _fill_ring(z, middle, last_z, last_r, level[j], at[j], kind[j])
    _interpolate(level, at, kind)
    return level


@callee()
def _lowest(
    points: Floats, distance: Floats, members: Integers, level: float, reachable: float
) -> tuple[float, float]:
    """(height, distance) of the lowest returns of a cell near ``level``; NaN if there is none."""
    least = np.inf
    for i in members:
        z = points[i, 2]
        if abs(z - level) <= reachable and z < least:
            least = z
    if least == np.inf:
        return np.nan, 0.0
    z_sum, r_sum, count = 0.0, 0.0, 0
    for i in members:
        if least <= points[i, 2] <= least + _THICKNESS:
            z_sum += points[i, 2]
            r_sum += distance[i]
            count += 1
    return z_sum / count, r_sum / count


@callee()
def _drop_raised(z: Floats, distance: float, slope: float, tolerance: float) -> None:
    """Set cells to NaN, in place, if two neighbours on the ring lie too far below."""
    arc = distance * 2.0 * math.pi / SECTORS
    high = np.zeros(SECTORS, dtype=np.bool_)
    for k in range(SECTORS):
        lower = 0
        for m in range(-_BESIDE, _BESIDE + 1):
            other = z[(k + m) % SECTORS]
            lower += other < z[k] - tolerance - slope * abs(m) * arc
        high[k] = lower >= 2
    for k in range(SECTORS):
        if high[k]:
            z[k] = np.nan


@callee()
def _fill_ring(
    z: Floats,
    middle: float,
    last_z: Floats,
    last_r: Floats,
    level: Floats,
    at: Floats,
    kind: Integers,
) -> None:
    """Fill cells of a ring without ground from their neighbours on the ring, in place."""
    arc = middle * 2.0 * math.pi / SECTORS
    for k in range(SECTORS):
        if not math.isnan(z[k]):
            continue
        left = right = 0
        for m in range(1, _BESIDE + 1):
            if left == 0 and not math.isnan(z[(k + m) % SECTORS]):
                left = m
            if right == 0 and not math.isnan(z[(k - m) % SECTORS]):
                right = m
        level[k], at[k] = last_z[k], middle
        if left > 0 and right > 0:
            share = right / (left + right)
            level[k] = share * z[(k + left) % SECTORS] + (1.0 - share) * z[(k - right) % SECTORS]
            kind[k] = _BETWEEN
        elif left + right > 0:
            near = (k + left) % SECTORS if left > 0 else (k - right) % SECTORS
            if middle - (left + right) * arc > last_r[k]:
                last_z[k], last_r[k] = z[near], middle - (left + right) * arc
                level[k] = z[near]
            continue
        else:
            continue
        last_z[k], last_r[k] = level[k], middle - min(left, right) * arc


@callee()
def _interpolate(level: Floats, at: Floats, kind: Integers) -> None:
    """Interpolate heights to the middle of their rings along each sector, in place."""
    rings = level.shape[0]
    r, z = np.empty(rings + 1), np.empty(rings + 1)
    for k in range(SECTORS):
        count = 1
        r[0], z[0] = 0.0, 0.0
        for j in range(rings):
            if kind[j, k] != _GUESSED and at[j, k] > r[count - 1]:
                r[count], z[count] = at[j, k], level[j, k]
                count += 1
        i = 0
        for j in range(rings):
            middle = (j + 0.5) * RING_WIDTH
            while i < count - 1 and r[i + 1] <= middle:
                i += 1
            if i < count - 1:
                share = (middle - r[i]) / (r[i + 1] - r[i])
                level[j, k] = (1.0 - share) * z[i] + share * z[i + 1]
            elif kind[j, k] != _GUESSED:
                level[j, k] = z[i]


@callee()
def _interpolated(level: Floats, distance: float, sector: float) -> float:
    """Height of the ground at a point, bilinear between the middles of the cells."""
    u = max(distance / RING_WIDTH - 0.5, 0.0)
    j = min(int(u), level.shape[0] - 2)
    u = min(u - j, 1.0)
    v = sector - 0.5
    k = math.floor(v)
    v -= k
    a, b = k % SECTORS, (k + 1) % SECTORS
    near = (1.0 - v) * level[j, a] + v * level[j, b]
    far = (1.0 - v) * level[j + 1, a] + v * level[j + 1, b]
    height: float = (1.0 - u) * near + u * far
    return height
