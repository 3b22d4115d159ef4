"""Kernels of the ground map: sweeps into cells, and how far wheels go on floor that is known."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Bytes, Floats, Floats32
from cohelm.kernels import CACHED, callee

UNSEEN, FLOOR, OBJECT, LOWER, HIGHER = 0, 1, 2, 3, 4
"""Kinds of cells: not seen; floor that wheels can take; the low part of a high object, as a foot;
behind an edge down; behind one up."""
SEEN = 2
"""Sweeps that must have seen a cell before its height counts as a step."""
_LAYER = 0.06
"""The floor of a cell is the mean of its returns up to this height over the lowest one, m; more
than noise, or the map would sink."""
_LEVEL, _HIGH = 0.02, 0.3
"""Returns at most this far from the chair's plane are floor on it, for sensors this high, m."""
_STRIDE = 0.5
"""Step along a ray below the floor, cells."""
_HANGING = 0.8
"""Objects that begin higher have no foot on the floor, m: awnings, half-open shutters."""
_MIRRORED = 3
"""Cells of floor below which a ray passes before its return counts as mirrored."""


class GroundCells(NamedTuple):
    """Cells (rows, cols) of the map, changed in place; 0 everywhere is an unseen floor."""

    height: Floats32
    """Of the floor, m; without meaning where it was never seen."""
    seen: Bytes
    """Sweeps with a return of the floor, at most 255."""
    bound: Floats32
    """Lowest ray that passed, m: the floor lies below it; without meaning where none did."""
    passed: Bytes
    """Sweeps with rays that passed below the chair's floor, at most 255."""
    tall: Bytes
    """Sweeps of the floor for which a high object still counts: what is low belongs to it."""
    kind: Bytes
    """One of the constants above."""


class GroundRules(NamedTuple):
    """Limits of the chair, and sizes; heights in m."""

    down: float
    """Least step down that counts."""
    up: float
    """Least step up that counts."""
    slope: float
    """Steepest floor, rise over run."""
    resolution: float
    """Side of a cell, m."""
    reach: float
    """Horizontal distance from the chair within which returns count, m."""
    outline: Floats
    """(4,) of x and y that bound the chair in its frame: returns there are its own, m."""
    dip: float
    """Depth below the chair's floor from which a ray counts as passing."""
    tall: float
    """Returns higher than this over the floor are objects."""
    top: float
    """Returns higher than this count for nothing."""
    lasting: int
    """Sweeps of the floor alone for which a high object counts, at most 254."""


@njit(**CACHED)
def add_sweep(
    cells: GroundCells,
    points: Floats32,
    rotation: Floats,
    origin: Floats,
    pose: Floats,
    range_max: float,
    tilt: Floats,
    rules: GroundRules,
) -> Floats:
    """Add a sweep to the cells, in place.

    Args:
        cells: of the map; the window's frame has its origin at the corner of the first cell.
        points: (p, 3) in the sensor's frame, m; NaN without a return.
        rotation, origin: (3, 3) and (3,), m, of the sensor in the window's frame, heights over the
            plane on which the chair stands.
        pose: (3,) of the chair in the window's frame.
        range_max: of the sensor, m; farther returns are none.
        tilt: (3,) expected height of that plane below the map's at the chair, m, and its slopes.
        rules: of the map.

    Returns:
        The tilt (3,) that fits the sweep to what was known.
    """
    chair = pose[:2].copy()
    low = _in_window(points, rotation, origin, pose, range_max, rules)
    tilt = _fitted(cells, low, chair, tilt, rules)
    for i in range(low.shape[0]):
        low[i, 2] -= tilt[0] + tilt[1] * (low[i, 0] - chair[0]) + tilt[2] * (low[i, 1] - chair[1])
    sensor = origin.copy()
    sensor[2] -= tilt[0] + tilt[1] * (origin[0] - chair[0]) + tilt[2] * (origin[1] - chair[1])
    low = _without_mirrored(cells.height.shape, low, sensor, -tilt[0], rules)
    _add_floor(cells, low, chair, tilt, rules)
    _add_passing(cells, low, sensor, -tilt[0], rules)
    return tilt


@callee()
def _in_window(
    points: Floats32,
    rotation: Floats,
    origin: Floats,
    pose: Floats,
    range_max: float,
    rules: GroundRules,
) -> Floats:
    """Returns (m, 3) not too high and within reach, or low, in the window's frame."""
    out = np.empty((points.shape[0], 3))
    count, r, own = 0, rotation, rules.outline
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for i in range(points.shape[0]):
        px, py, pz = np.float64(points[i, 0]), np.float64(points[i, 1]), np.float64(points[i, 2])
        if not 0.0025 < px * px + py * py + pz * pz <= range_max * range_max:  # NaN neither
            continue
        z = origin[2] + r[2, 0] * px + r[2, 1] * py + r[2, 2] * pz
        x = origin[0] + r[0, 0] * px + r[0, 1] * py + r[0, 2] * pz
        y = origin[1] + r[1, 0] * px + r[1, 1] * py + r[1, 2] * pz
        dx, dy = x - pose[0], y - pose[1]
        away = math.hypot(dx, dy)
        ahead, aside = cos * dx + sin * dy, cos * dy - sin * dx
        if own[0] < ahead < own[1] and own[2] < aside < own[3]:
            continue
        if abs(z) < _LEVEL and origin[2] > _HIGH:
            # By its noise alone, a return that is too far lies too low and in a later cell, where
            # there may be no other one: it counts where its ray meets the plane.
            along = z / (origin[2] - z)
            x, y = x + along * (x - origin[0]), y + along * (y - origin[1])
        if z < rules.top and (away <= rules.reach or z < -rules.dip):
            out[count, 0], out[count, 1], out[count, 2] = x, y, z
            count += 1
    return out[:count]


@callee()
def _fitted(
    cells: GroundCells, low: Floats, chair: Floats, tilt: Floats, rules: GroundRules
) -> Floats:
    """Tilt (3,) that fits returns to the heights of their cells, by least squares, twice.

    The expected tilt counts as much as a handful of returns, so that few of them change little.
    """
    rows, cols = cells.height.shape
    out = tilt.copy()
    for gate, growth in ((0.05, 0.04), (0.02, 0.01)):
        A, b = np.zeros((3, 3)), np.zeros(3)
        for i in range(low.shape[0]):
            x, y = low[i, 0] - chair[0], low[i, 1] - chair[1]
            if math.hypot(x, y) > rules.reach:
                continue
            c, r = int(low[i, 0] / rules.resolution), int(low[i, 1] / rules.resolution)
            if not (0 <= r < rows and 0 <= c < cols) or low[i, 0] < 0.0 or low[i, 1] < 0.0:
                continue
            if cells.seen[r, c] < SEEN or cells.kind[r, c] != FLOOR or cells.tall[r, c] > 0:
                continue
            off = low[i, 2] - cells.height[r, c]
            if abs(off - out[0] - out[1] * x - out[2] * y) > gate + growth * math.hypot(x, y):
                continue
            off -= tilt[0] + tilt[1] * x + tilt[2] * y
            A[0, 0] += 1.0
            A[0, 1] += x
            A[0, 2] += y
            A[1, 1] += x * x
            A[1, 2] += x * y
            A[2, 2] += y * y
            b[0] += off
            b[1] += off * x
            b[2] += off * y
        A[0, 0] += 20.0
        A[1, 1] += 20.0
        A[2, 2] += 20.0
        out = tilt + _solved(A, b)
    return out


@callee()
def _solved(A: Floats, b: Floats) -> Floats:
    """Solution (3,) of a positive definite system of which the upper triangle is given."""
    l00 = math.sqrt(A[0, 0])
    l10, l20 = A[0, 1] / l00, A[0, 2] / l00
    l11 = math.sqrt(A[1, 1] - l10 * l10)
    l21 = (A[1, 2] - l20 * l10) / l11
    l22 = math.sqrt(A[2, 2] - l20 * l20 - l21 * l21)
    u = b[0] / l00
    v = (b[1] - l10 * u) / l11
    w = (b[2] - l20 * u - l21 * v) / l22
    z = w / l22
    y = (v - l21 * z) / l11
    return np.array([(u - l10 * y - l20 * z) / l00, y, z])


@callee()
def _without_mirrored(
    shape: tuple[int, int], low: Floats, sensor: Floats, level: float, rules: GroundRules
) -> Floats:
    """Returns without those whose rays pass below floor of this sweep: glossy floor mirrors.

    Floor of earlier sweeps does not count: it may have gone, as a platform lift.
    """
    rows, cols = shape
    lit = np.full(rows * cols, np.inf)  # lowest return that is not below the chair's floor
    for i in range(low.shape[0]):
        c, r = math.floor(low[i, 0] / rules.resolution), math.floor(low[i, 1] / rules.resolution)
        if -rules.dip <= low[i, 2] - level <= rules.tall and 0 <= r < rows and 0 <= c < cols:
            lit[r * cols + c] = min(lit[r * cols + c], low[i, 2])
    out, count = np.empty_like(low), 0
    for i in range(low.shape[0]):
        below, last, depth = 0, -1, level - low[i, 2]
        away = math.hypot(sensor[0] - low[i, 0], sensor[1] - low[i, 1])
        if depth > rules.dip and away > 1e-6 and sensor[2] > low[i, 2]:
            dx, dy = (sensor[0] - low[i, 0]) / away, (sensor[1] - low[i, 1]) / away
            rise = (sensor[2] - low[i, 2]) / away
            t = 0.0
            while t < min((depth - rules.dip) / rise, away) and below < _MIRRORED:
                x, y = low[i, 0] + dx * t, low[i, 1] + dy * t
                c, r = math.floor(x / rules.resolution), math.floor(y / rules.resolution)
                k = r * cols + c
                if 0 <= r < rows and 0 <= c < cols and k != last:
                    z = low[i, 2] + rise * t + rules.down
                    below += z < lit[k] < np.inf
                    last = k
                t += _STRIDE * rules.resolution
        if below < _MIRRORED:
            out[count] = low[i]
            count += 1
    return out[:count]


@callee()
def _add_floor(
    cells: GroundCells, low: Floats, chair: Floats, tilt: Floats, rules: GroundRules
) -> None:
    """Fuse the lowest returns of each cell into its height, and note high objects."""
    rows, cols = cells.height.shape
    cell, high = np.full(low.shape[0], -1, dtype=np.int64), np.zeros(low.shape[0], dtype=np.bool_)
    least = np.full(rows * cols, np.inf)
    for i in range(low.shape[0]):
        if low[i, 0] < 0.0 or low[i, 1] < 0.0:
            continue
        c, r = int(low[i, 0] / rules.resolution), int(low[i, 1] / rules.resolution)
        if r >= rows or c >= cols:
            continue
        over = low[i, 2] + tilt[0]
        away = math.hypot(low[i, 0] - chair[0], low[i, 1] - chair[1])
        if away > rules.reach:  # only low ones are given
            continue
        cell[i], high[i] = r * cols + c, over > rules.tall + rules.slope * away
        if high[i]:
            if over < _HANGING + rules.slope * away:
                cells.tall[r, c] = rules.lasting + 1
        else:
            least[cell[i]] = min(least[cell[i]], low[i, 2])
    total, count = np.zeros(rows * cols), np.zeros(rows * cols, dtype=np.int64)
    for i in range(low.shape[0]):
        if cell[i] >= 0 and not high[i] and low[i, 2] <= least[cell[i]] + _LAYER:
            total[cell[i]] += low[i, 2]
            count[cell[i]] += 1
    for i in range(low.shape[0]):
        r, c = cell[i] // cols, cell[i] % cols
        if cell[i] < 0 or count[cell[i]] < 0:  # that cell is done
            continue
        # A high object is forgotten where only floor is seen, and not while nobody looks.
        if cells.tall[r, c] > 0:
            cells.tall[r, c] -= 1
        if count[cell[i]] > 0:
            n = cells.seen[r, c]
            # Newer sweeps are nearer ones, and better.
            share = max(1.0 / (n + 1.0), 0.25)
            before = cells.height[r, c] if n > 0 else 0.0
            cells.height[r, c] = before + share * (total[cell[i]] / count[cell[i]] - before)
            cells.seen[r, c] = min(n + 1, 255)
        count[cell[i]] = -1


@callee()
def _add_passing(
    cells: GroundCells, low: Floats, sensor: Floats, level: float, rules: GroundRules
) -> None:
    """Note rays on their last way below the chair's floor: where they pass there is none.

    Floor that a ray passes far below, and that no return shows any more, is soon forgotten.
    """
    rows, cols = cells.height.shape
    fresh, lit = np.zeros(rows * cols, dtype=np.bool_), np.zeros(rows * cols, dtype=np.bool_)
    for i in range(low.shape[0]):
        c, r = math.floor(low[i, 0] / rules.resolution), math.floor(low[i, 1] / rules.resolution)
        if 0 <= r < rows and 0 <= c < cols:
            lit[r * cols + c] = True
    for i in range(low.shape[0]):
        if low[i, 2] > level - rules.dip:
            continue
        dx, dy = sensor[0] - low[i, 0], sensor[1] - low[i, 1]
        away = math.hypot(dx, dy)
        if away < 1e-6 or sensor[2] <= low[i, 2]:
            continue
        rise = (sensor[2] - low[i, 2]) / away
        # From where the ray sinks below the floor to its return, without the return's own cell.
        first = max(away - (level - 0.5 * rules.dip - low[i, 2]) / rise, 0.0)
        t = rules.resolution
        while t < away - first:
            x, y = low[i, 0] + dx / away * t, low[i, 1] + dy / away * t
            c, r = math.floor(x / rules.resolution), math.floor(y / rules.resolution)
            if 0 <= r < rows and 0 <= c < cols:
                z = low[i, 2] + rise * t
                if cells.passed[r, c] == 0 or z < cells.bound[r, c]:
                    cells.bound[r, c] = z
                if not (fresh[r * cols + c] or lit[r * cols + c]):
                    cells.seen[r, c] //= 2 if z < cells.height[r, c] - rules.down else 1
                fresh[r * cols + c] = True
            t += _STRIDE * rules.resolution
    for k in range(rows * cols):
        if fresh[k] and cells.passed[k // cols, k % cols] < 255:
            cells.passed[k // cols, k % cols] += 1


@njit(**CACHED)
def stand_on(
    cells: GroundCells, wheels: Floats, pose: Floats, around: float, level: float, resolution: float
) -> None:
    """Count cells between the wheels of a chair as floor, in place; about it as floor seen once.

    Args:
        cells: of the map.
        wheels: (k, 2), their places in the robot frame, m.
        pose: (3,) in the window's frame.
        around: radius of a circle about the axle that counts as well, m.
        level: height of the floor, m.
        resolution: side of a cell, m.
    """
    rows, cols = cells.height.shape
    x0, x1 = wheels[:, 0].min(), wheels[:, 0].max()
    y0, y1 = wheels[:, 1].min(), wheels[:, 1].max()
    far = max(around, math.hypot(max(-x0, x1), max(-y0, y1)))
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for r in range(
        max(int((pose[1] - far) / resolution), 0), min(int((pose[1] + far) / resolution) + 1, rows)
    ):
        for c in range(
            max(int((pose[0] - far) / resolution), 0),
            min(int((pose[0] + far) / resolution) + 1, cols),
        ):
            dx, dy = (c + 0.5) * resolution - pose[0], (r + 0.5) * resolution - pose[1]
            x, y = cos * dx + sin * dy, cos * dy - sin * dx
            between = x0 <= x <= x1 and y0 <= y <= y1
            sweeps = SEEN if between else 1 if math.hypot(dx, dy) <= around else 0
            if cells.seen[r, c] < sweeps and cells.kind[r, c] < LOWER:
                cells.height[r, c], cells.seen[r, c] = level, sweeps


@njit(**CACHED)
def known_distance(
    cells: GroundCells,
    wheels: Floats,
    pose: Floats,
    twist: Floats,
    resolution: float,
    max_distance: float,
    sweeps: int,
) -> float:
    """Distance that the outermost of moving wheels goes over floor that is known, m.

    Args:
        cells: of the map.
        wheels: (k, 2), their places in the robot frame, m.
        pose: (3,) in the window's frame.
        twist: (3,) that is kept, robot frame; at rest the whole distance is known.
        resolution: side of a cell, m.
        max_distance: m.
        sweeps: that have seen a cell which is known; with 1 also floor on which the chair stood.
    """
    rows, cols = cells.height.shape
    fastest = 0.0
    for k in range(wheels.shape[0]):
        vx, vy = twist[0] - twist[2] * wheels[k, 1], twist[1] + twist[2] * wheels[k, 0]
        fastest = max(fastest, math.hypot(vx, vy))
    if fastest < 1e-9:
        return max_distance
    stride = 0.2 * resolution  # a distance that fell cell by cell would ask for hard braking
    dt = stride / fastest
    x, y, angle, distance = pose[0], pose[1], pose[2], 0.0
    while distance < max_distance:
        middle = angle + 0.5 * dt * twist[2]
        cos, sin = math.cos(middle), math.sin(middle)
        x += dt * (cos * twist[0] - sin * twist[1])
        y += dt * (sin * twist[0] + cos * twist[1])
        angle += dt * twist[2]
        cos, sin = math.cos(angle), math.sin(angle)
        for k in range(wheels.shape[0]):
            px = x + cos * wheels[k, 0] - sin * wheels[k, 1]
            py = y + sin * wheels[k, 0] + cos * wheels[k, 1]
            r, c = math.floor(py / resolution), math.floor(px / resolution)
            if not (0 <= r < rows and 0 <= c < cols):
                return distance
            if cells.seen[r, c] < sweeps and cells.kind[r, c] < OBJECT:
                return distance
        distance += stride
    return max_distance
