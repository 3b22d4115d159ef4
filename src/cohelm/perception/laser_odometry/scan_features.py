"""Features of scans and clouds for matching: faces with normals, posts, edges and corners.

A face constrains the pose across itself only; a post, an edge or a corner in both directions.
An object no wider than a person may walk, so its features weigh together as much as one of a wall.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.geometry import transform
from cohelm.kernels import CACHED, callee
from cohelm.messages import Observation, PointCloud, Scan
from cohelm.perception.preprocessing.merged_cloud import merge_clouds
from cohelm.perception.preprocessing.scan_returns import scan_returns

_REACH = 30.0
"""Largest range of a cloud, m: beyond it, the rings are too far apart."""
_AZIMUTHS, _CELL = 720, 0.25
"""Directions of a cloud, and the depth of their cells, m."""
_LOW, _HIGH, _UPRIGHT = 0.3, 2.0, 0.15
"""Heights of the slice of a cloud, and the least height of an upright object in a cell, m."""
_POST_WIDTH = 0.3
"""A narrower object in front of everything beside it is a post, m."""
_DEPTH_STEP = 0.1
"""Least distance in front of it, m."""
_BODY = 0.9
"""Largest breadth of an object that may be a person, m: arms spread, or a bag beside them."""
_JUMP, _GRAZING = 0.08, 6.0
"""Largest gap in a face, m, plus a multiple of the gap between perpendicular beams (6: at 80°)."""
_WINDOW, _LEAST = 0.12, 4
"""Half the breadth for the estimate of a normal, m, and the least number of returns."""
_ROUGH = 0.03
"""Largest standard deviation of a flat face, m."""
_FINE = 0.06
"""Largest gap between beams at an edge or a corner, m."""
_THIN = 0.025
"""Least distance between the points of a face, m."""


@value
class ScanFeatures:
    """Features of a reading, in the robot's frame unless noted otherwise; k points."""

    points: Annotated[Floats, Shape("k 2")]
    """m."""
    normals: Annotated[Floats, Shape("k 2")]
    """Unit normals of faces towards the sensor; 0 for point features."""
    weights: Annotated[Floats, Shape("k")] | None = None
    """Weights as evidence of static surroundings, 0…1; None: all 1."""

    @property
    def rows(self) -> Floats:
        """Points, normals and weights, (k, 5)."""
        weights = np.ones(len(self)) if self.weights is None else self.weights
        return np.column_stack([self.points, self.normals, weights])

    @property
    def evidence(self) -> float:
        """Sum of the weights."""
        return float(len(self) if self.weights is None else self.weights.sum())

    def transformed(self, X: Floats) -> ScanFeatures:
        """Transform to the frame in which the present one has pose X (3,)."""
        return replace(
            self,
            points=transform(X, self.points),
            normals=transform(np.array([0.0, 0.0, X[2]]), self.normals),
        )

    def __len__(self) -> int:
        """Number of points."""
        return len(self.points)


def extract_features(observation: Observation) -> ScanFeatures:
    """Extract the features of all scans and clouds of an observation."""
    parts = [features_of_scan(scan) for scan in observation.scans]
    parts += [features_of_cloud(cloud) for cloud in observation.clouds]
    return _of_rows(np.concatenate([np.empty((0, 5)), *(each.rows for each in parts)]))


def _of_rows(rows: Floats) -> ScanFeatures:
    """Features from ``ScanFeatures.rows``."""
    return ScanFeatures(points=rows[:, :2], normals=rows[:, 2:4], weights=rows[:, 4])


def features_of_scan(scan: Scan) -> ScanFeatures:
    """Extract the features of a planar scan."""
    seen = scan_returns(scan, np.zeros(3))
    return _of_rows(extract_faces(seen.points, seen.origin, seen.increment))


def features_of_cloud(cloud: PointCloud) -> ScanFeatures:
    """Extract the features of a cloud from its nearest upright objects between knee and head."""
    seen = merge_clouds((cloud,), np.zeros((1, 3)), _REACH)
    cells, step = nearest_upright_cells(seen.points), 2.0 * math.pi / _AZIMUTHS
    return _of_rows(extract_faces(cells, np.zeros(2), step)).transformed(seen.X_MS)


@njit(**CACHED)
def nearest_upright_cells(points: Floats) -> Floats:
    """Find the nearest cell with an upright object in each azimuth; mean of its points, (q, 2).

    Args:
        points: (p, 3) about the sensor, z from the floor, m.
    """
    cells = int(_REACH / _CELL) + 2
    low = np.full((_AZIMUTHS, cells), np.inf)
    high = np.full((_AZIMUTHS, cells), -np.inf)
    sums = np.zeros((_AZIMUTHS, cells, 2))
    count = np.zeros((_AZIMUTHS, cells))
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        if not _LOW <= z <= _HIGH:
            continue
        a = int((math.atan2(y, x) + math.pi) * (_AZIMUTHS / (2.0 * math.pi))) % _AZIMUTHS
        c = min(int(math.hypot(x, y) / _CELL), cells - 1)
        low[a, c], high[a, c] = min(low[a, c], z), max(high[a, c], z)
        sums[a, c, 0] += x
        sums[a, c, 1] += y
        count[a, c] += 1.0
    out = np.empty((_AZIMUTHS, 2))
    q = 0
    for a in range(_AZIMUTHS):
        for c in range(cells):
            if high[a, c] - low[a, c] >= _UPRIGHT:
                out[q, 0], out[q, 1] = sums[a, c, 0] / count[a, c], sums[a, c, 1] / count[a, c]
                q += 1
                break
    return out[:q]


@njit(**CACHED)
def extract_faces(points: Floats, origin: Floats, increment: float) -> Floats:
    """Extract rows (k, 5) of points, normals and weights from the runs between jumps of depth.

    Args:
        points: (p, 2), counter-clockwise about the sensor, m.
        origin: (2,) of the sensor, m.
        increment: angle between neighbouring beams, rad.
    """
    p = points.shape[0]
    away = np.empty(p)
    for i in range(p):
        away[i] = math.hypot(points[i, 0] - origin[0], points[i, 1] - origin[1])
    out = np.zeros((2 * p, 5))
    spacing = _GRAZING * increment * away
    k, first, begin, breadth = 0, 0, 0, 0.0
    for i in range(p):
        # The largest distance, since the walls of a room end where they begin.
        breadth = max(breadth, _distance(points, begin, i))
        if i + 1 < p:
            gap = _distance(points, i, i + 1)
            if gap <= _JUMP + _GRAZING * increment * min(away[i], away[i + 1]):
                continue
        end = i + 1
        if breadth >= _POST_WIDTH:
            k = _face(points, origin, spacing, (begin, end), out, k)
            # An end in front of its neighbour is an edge.
            for edge, beyond in ((begin, begin - 1), (i, end)):
                if 0 <= beyond < p and away[beyond] > away[edge] + 2.0 * _DEPTH_STEP:
                    inner = edge + 1 if edge == begin else edge - 1
                    if _distance(points, edge, inner) <= _FINE:
                        out[k, :2] = points[edge]
                        k += 1
        elif end - begin >= 2:
            before = begin > 0 and away[begin - 1] > away[begin] + _DEPTH_STEP
            behind = end < p and away[end] > away[i] + _DEPTH_STEP
            if before and behind:
                out[k, 0] = points[begin:end, 0].mean()
                out[k, 1] = points[begin:end, 1].mean()
                k += 1
        out[first:k, 4] = 1.0 if breadth > _BODY else 1.0 / max(k - first, 1)
        first, begin, breadth = k, end, 0.0
    return out[:k]


@callee()
def _distance(points: Floats, i: int, j: int) -> float:
    return math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])


@callee()
def _face(
    points: Floats, origin: Floats, spacing: Floats, run: tuple[int, int], out: Floats, k: int
) -> int:
    """Append the thinned points of a run with their normals; return the new number of points."""
    begin, end = run
    last = -1
    for i in range(begin, end):
        if last >= 0 and _distance(points, last, i) < _THIN:
            continue
        window = _WINDOW + 0.5 * spacing[i]
        a, b = i, i + 1
        while a > begin and _distance(points, a - 1, i) <= window:
            a -= 1
        while b < end and _distance(points, b, i) <= window:
            b += 1
        n = b - a
        if n < _LEAST:
            continue
        mx = my = xx = xy = yy = 0.0
        for j in range(a, b):
            mx += points[j, 0]
            my += points[j, 1]
        mx, my = mx / n, my / n
        for j in range(a, b):
            dx, dy = points[j, 0] - mx, points[j, 1] - my
            xx += dx * dx / n
            xy += dx * dy / n
            yy += dy * dy / n
        half = math.hypot(0.5 * (xx - yy), xy)
        large, small = 0.5 * (xx + yy) + half, 0.5 * (xx + yy) - half
        if small > _ROUGH**2 or large < 6.0 * small:
            if spacing[i] <= _GRAZING * _FINE:
                out[k, 0], out[k, 1] = points[i, 0], points[i, 1]
                k += 1
                last = i
            continue
        along = 0.5 * math.atan2(2.0 * xy, xx - yy)
        nx, ny = -math.sin(along), math.cos(along)
        if nx * (origin[0] - mx) + ny * (origin[1] - my) < 0.0:
            nx, ny = -nx, -ny
        # Projected onto the line of its neighbours: less noise than the return itself.
        off = nx * (points[i, 0] - mx) + ny * (points[i, 1] - my)
        out[k, 0], out[k, 1] = points[i, 0] - off * nx, points[i, 1] - off * ny
        out[k, 2], out[k, 3] = nx, ny
        k += 1
        last = i
    return k
