"""Fit of a sweep to the map at a pose: a share of beams, and the offset that would fit best.

Each beam is compared with the map's expected range, as in the beam model of Thrun, Burgard and Fox
(Probabilistic Robotics, 2005, ch. 6). A return *before* the expected wall may be a person or
furniture; only beams that pass *through* a mapped wall, or find nothing where one should be,
contradict the pose. That makes the fit robust to crowds and to furniture that the map lacks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Floats32, Integers, SignedBytes
from cohelm.kernels import CACHED, callee
from cohelm.maps import FREE, UNKNOWN, DistanceField, OccupancyGrid, distance_field
from cohelm.maps.distance import sample
from cohelm.planar_fit import add_row, newton_step

IGNORED, HIT, SHORT, THROUGH, MISSING, UNUSABLE = 0, 1, 2, 3, 4, 5
"""Class of a beam: no expectation; on a wall of the map; before it; beyond it; free although a wall
is near; no believable reading."""
_NEAR = 0.9
"""Share of the sensor's range within which a wall must give a return."""
_PASSES = 8


class BeamTable(NamedTuple):
    """Sampled beams (n,) of a sweep."""

    angle: Floats
    """In the robot's frame, rad, not wrapped."""
    range: Floats
    """m; +inf: free."""
    usable: Booleans


class MapFit(NamedTuple):
    """Result of :func:`fit_map`."""

    beams: Integers
    """Class of each beam (n,)."""
    expected: Floats
    """Expected range (n,), m; +inf: none within range, NaN: not known."""
    hit: int
    short: int
    through: int
    missing: int
    offset: Floats
    """Correction (3,) in the map frame that fits better, m and rad; 0 where nothing constrains."""
    gain: float
    """Additional share of the returns that lie on walls with the correction."""

    @property
    def contradiction(self) -> float:
        """Share of the informative beams that contradict the map, 0…1."""
        informative = self.hit + self.through + self.missing
        return (self.through + self.missing) / informative if informative else 0.0

    @property
    def informative(self) -> float:
        """Share of the beams that reach the map's walls or contradict them."""
        return (self.hit + self.through + self.missing) / max(len(self.beams), 1)


class SolidMap(NamedTuple):
    """Map for beams: unknown cells neither reflect nor stop them."""

    distance: Floats32
    """Signed distance to occupied cells, (rows, cols), m."""
    data: SignedBytes
    resolution: float
    X_MG: Floats


def beam_map(grid: OccupancyGrid, walls: DistanceField) -> SolidMap:
    """Map for beams; ``walls`` is the distance field of occupied and unknown cells."""
    unknown = grid.data == UNKNOWN
    if unknown.any():
        known = np.where(unknown, np.int8(FREE), grid.data)
        walls = distance_field(
            OccupancyGrid(data=known, resolution=grid.resolution, X_MG=grid.X_MG)
        )
    return SolidMap(walls.distance, grid.data, grid.resolution, walls.X_MG)


def fit_map(
    known: SolidMap, beams: BeamTable, X_MS: Floats, range_max: float, tol: float
) -> MapFit:
    """Compare the beams of a sweep at a sensor pose (3,) with the map.

    Args:
        known: the map.
        beams: of the sweep, angles from the sensor's x axis.
        X_MS: pose of the sensor.
        range_max: of the sensor, m.
        tol: distance from a mapped wall within which a return lies on it, m.
    """
    kinds, expected, counts = _classify(known, beams, X_MS, range_max, tol)
    offset, gain = _best_offset(known, beams, X_MS, tol)
    hit, short, through, missing = (int(counts[k]) for k in (HIT, SHORT, THROUGH, MISSING))
    return MapFit(kinds, expected, hit, short, through, missing, offset, gain)


@callee()
def _cell(known: SolidMap, x: float, y: float) -> tuple[int, int, bool]:
    """Row and column of a map point, and True if it lies on the map."""
    c, s = math.cos(known.X_MG[2]), math.sin(known.X_MG[2])
    dx, dy = x - known.X_MG[0], y - known.X_MG[1]
    col = math.floor((c * dx + s * dy) / known.resolution)
    row = math.floor((-s * dx + c * dy) / known.resolution)
    inside = 0 <= row < known.distance.shape[0] and 0 <= col < known.distance.shape[1]
    return int(row), int(col), inside


@callee()
def _expected(known: SolidMap, X_MS: Floats, angle: float, range_max: float) -> float:
    """Range to the first occupied cell, m; +inf: none, NaN: unknown cells come first."""
    ux, uy = math.cos(X_MS[2] + angle), math.sin(X_MS[2] + angle)
    half, s, unknown = 0.5 * known.resolution, 0.0, 0.0
    while s < range_max:
        row, col, inside = _cell(known, X_MS[0] + s * ux, X_MS[1] + s * uy)
        if not inside:
            return math.nan
        d = float(known.distance[row, col])
        if d <= 0.0:
            return s
        step = max(d - half, half)
        if known.data[row, col] == UNKNOWN:
            unknown += step
            if unknown > 0.3:
                return math.nan
        s += step
    return math.inf


@njit(**CACHED)
def _classify(
    known: SolidMap, beams: BeamTable, X_MS: Floats, range_max: float, tol: float
) -> tuple[Integers, Floats, Integers]:
    n = len(beams.angle)
    kinds, expected = np.zeros(n, dtype=np.int64), np.empty(n)
    for i in range(n):
        expected[i] = _expected(known, X_MS, beams.angle[i], range_max)
    counts = np.zeros(6, dtype=np.int64)
    for i in range(n):
        e, r = expected[i], beams.range[i]
        if not beams.usable[i]:
            kinds[i] = UNUSABLE
        elif r == math.inf:
            # A neighbour that expects nothing excuses an edge.
            far = max(expected[i - 1], e, expected[(i + 1) % n])
            kinds[i] = MISSING if far < _NEAR * range_max else IGNORED
        else:
            a = X_MS[2] + beams.angle[i]
            row, col, inside = _cell(known, X_MS[0] + r * math.cos(a), X_MS[1] + r * math.sin(a))
            if inside and abs(known.distance[row, col]) <= tol:
                kinds[i] = HIT
            elif math.isnan(e):
                kinds[i] = IGNORED
            elif r < e:
                kinds[i] = SHORT
            else:
                far = max(expected[i - 1], e, expected[(i + 1) % n])
                kinds[i] = THROUGH if r > far + 2.0 * tol else IGNORED
        counts[kinds[i]] += 1
    return kinds, expected, counts


@njit(**CACHED)
def _best_offset(
    known: SolidMap, beams: BeamTable, X_MS: Floats, tol: float
) -> tuple[Floats, float]:
    """Gauss-Newton on the squared distances to walls, with Geman-McClure weights."""
    offset, n, reach = np.zeros(3), len(beams.angle), 0.6
    on_before, on_after, returns = 0, 0, 0
    for k in range(_PASSES + 1):
        H, g = np.diag(np.array([2.0, 2.0, 4.0])), np.array([2.0, 2.0, 4.0]) * offset
        scale = max(0.4 * 0.75**k, 0.1)
        on_after, returns = 0, 0
        for i in range(n):
            r = beams.range[i]
            if not beams.usable[i] or r == math.inf:
                continue
            returns += 1
            a = X_MS[2] + offset[2] + beams.angle[i]
            rx, ry = r * math.cos(a), r * math.sin(a)
            x, y = X_MS[0] + offset[0] + rx, X_MS[1] + offset[1] + ry
            _, _, inside = _cell(known, x, y)
            if not inside:
                continue
            d, gx, gy = sample(known.distance, known.resolution, known.X_MG, x, y)
            on_after += abs(d) <= 0.7 * tol
            if abs(d) > reach:
                continue
            w = 1.0 / (1.0 + (d / scale) ** 2) ** 2
            turn = -gx * ry + gy * rx
            add_row(H, g, gx, gy, turn, d, w)
        if k == 0:
            on_before = on_after
        if k == _PASSES:
            break
        offset += newton_step(H, g)
        if abs(offset[0]) > 1.0 or abs(offset[1]) > 1.0 or abs(offset[2]) > 0.6:
            return np.zeros(3), 0.0
    return offset, (on_after - on_before) / max(returns, 1)
