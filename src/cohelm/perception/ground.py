"""The ground about a sensor: level, sloping, stepped, seen by rings far apart or hidden.

The plane is cut into sectors and rings. Outwards from the robot, which stands on the ground, each
cell's lowest returns are its ground if they can be reached from the ground before by a slope that a
chair can drive; what is higher stands on it, what is lower lies below a step. Beside, the lower
neighbour wins. So a box or a kerb stays one, and a ramp does not become one.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers

SECTORS = 120
"""Round the horizon (3° each)."""
RING = 0.3
"""Width of a ring, m."""
_THICKNESS = 0.08
"""The ground is the mean of a cell's returns this far above its lowest one, m."""
_BESIDE = 6
"""Sectors on either side with which a cell is compared."""
_GROUND, _BETWEEN, _GUESSED = 2, 1, 0


@njit(cache=True)
def ground_heights(points: Floats, slope: float, tolerance: float, reach: float) -> Floats:
    """Height of each point (p,) above the ground below it, m.

    Args:
        points: (p, 3), x and y from the sensor, z from the floor under the robot, m.
        slope: steepest ground, rise over run.
        tolerance: by which ground may rise or fall at once, m.
        reach: no point is farther, m.
    """
    n = points.shape[0]
    rings = int(reach / RING) + 2
    away = np.empty(n)
    sector = np.empty(n)
    for i in range(n):
        x, y = points[i, 0], points[i, 1]
        away[i] = math.sqrt(x * x + y * y)
        sector[i] = (math.atan2(y, x) / (2.0 * math.pi) + 0.5) * SECTORS
    first, order, tall = _sorted(points, away, sector, rings, slope, tolerance)
    level = _grown(points, away, first, order, tall, slope, tolerance, rings)
    out = np.empty(n)
    for i in range(n):
        out[i] = points[i, 2] - _between(level, away[i], sector[i])
    return out


@njit(cache=True)
def _sorted(
    points: Floats, away: Floats, sector: Floats, rings: int, slope: float, tolerance: float
) -> tuple[Integers, Integers, Integers]:
    """Points low enough to be ground, by cell; and how many higher ones each cell has."""
    n = points.shape[0]
    first = np.zeros(rings * SECTORS + 1, dtype=np.int64)
    tall = np.zeros(rings * SECTORS, dtype=np.int64)
    cell = np.empty(n, dtype=np.int64)
    for i in range(n):
        c = int(away[i] / RING) * SECTORS + min(int(sector[i]), SECTORS - 1)
        most = 3.0 * tolerance + slope * away[i]
        z = points[i, 2]
        cell[i] = -1
        if abs(z) <= most:
            cell[i] = c
            first[c + 1] += 1
        if z > 0.3 + most or (z > 0.3 and away[i] < 3.0):
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


@njit(cache=True)
def _grown(  # noqa: PLR0917  # a kernel takes arrays and numbers
    points: Floats,
    away: Floats,
    first: Integers,
    order: Integers,
    tall: Integers,
    slope: float,
    tolerance: float,
    rings: int,
) -> Floats:
    """The ground's height (rings, SECTORS) in the middle of each cell."""
    last_z, last_r = np.zeros(SECTORS), np.zeros(SECTORS)
    level, at = np.zeros((rings, SECTORS)), np.zeros((rings, SECTORS))
    kind = np.zeros((rings, SECTORS), dtype=np.int64)
    for j in range(rings):
        middle = (j + 0.5) * RING
        z, r = np.full(SECTORS, np.nan), np.full(SECTORS, middle)
        for k in range(SECTORS):
            c = j * SECTORS + k
            if first[c + 1] > first[c]:
                reachable = tolerance + slope * max(middle - last_r[k], 0.0)
                if tall[c] > 0:
                    reachable = min(reachable, tolerance + 0.25 * slope * (middle - last_r[k]))
                members = order[first[c] : first[c + 1]]
                z[k], r[k] = _lowest(points, away, members, last_z[k], reachable)
        _compare(z, middle, slope, tolerance)
        for k in range(SECTORS):
            if math.isnan(z[k]):
                continue
            level[j, k], at[j, k], kind[j, k] = z[k], r[k], _GROUND
            last_z[k], last_r[k] = z[k], r[k]
        _beside(z, middle, last_z, last_r, level[j], at[j], kind[j])
    _interpolate(level, at, kind)
    return level


@njit(cache=True)
def _lowest(
    points: Floats, away: Floats, members: Integers, level: float, reachable: float
) -> tuple[float, float]:
    """(height, distance) of the lowest returns of a cell near ``level``; NaN without any."""
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
            r_sum += away[i]
            count += 1
    return z_sum / count, r_sum / count


@njit(cache=True)
def _compare(z: Floats, away: float, slope: float, tolerance: float) -> None:
    """Take back, in place, what two cells beside on the same ring lie too far below."""
    arc = away * 2.0 * math.pi / SECTORS
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


@njit(cache=True)
def _beside(  # noqa: PLR0917  # a kernel takes arrays and numbers
    z: Floats,
    middle: float,
    last_z: Floats,
    last_r: Floats,
    level: Floats,
    at: Floats,
    kind: Integers,
) -> None:
    """Where a ring shows no ground, take it from beside, in place."""
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


@njit(cache=True)
def _interpolate(level: Floats, at: Floats, kind: Integers) -> None:
    """Bring heights to the middle of their rings, and fill gaps along each sector; in place."""
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
            middle = (j + 0.5) * RING
            while i < count - 1 and r[i + 1] <= middle:
                i += 1
            if i < count - 1:
                share = (middle - r[i]) / (r[i + 1] - r[i])
                level[j, k] = (1.0 - share) * z[i] + share * z[i + 1]
            elif kind[j, k] != _GUESSED:
                level[j, k] = z[i]


@njit(cache=True)
def _between(level: Floats, away: float, sector: float) -> float:
    """Height of the ground, between the middles of the cells."""
    u = max(away / RING - 0.5, 0.0)
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
