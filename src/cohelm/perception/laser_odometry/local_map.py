"""Map of scan features in cells, for the search of nearest neighbours."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.kernels import CACHED, callee
from cohelm.perception.laser_odometry.scan_features import ScanFeatures

CELL = 0.25
"""Side of the cells, m."""
_MIN_COSINE = 0.8
"""Least cosine between the normals of one face."""


@value
class FeatureMap:
    """Features sorted into cells; k points in c cells."""

    features: ScanFeatures
    """In the order of the cells."""
    origin: Annotated[Floats, Shape("2")]
    """Corner of the first cell, m."""
    n_cols: int
    """Cells in a row."""
    cell_start: Annotated[Integers, Shape("c+1")]
    """First point of each cell, and the end of the last."""

    @property
    def cells(self) -> Cells:
        """The map for compiled code."""
        return Cells(self.features.rows, self.origin, self.n_cols, self.cell_start)


class Cells(NamedTuple):
    """A :class:`FeatureMap` for compiled code."""

    known: Floats
    """(k, 5): rows of the features."""
    origin: Floats
    n_cols: int
    cell_start: Integers


def feature_map(features: ScanFeatures) -> FeatureMap:
    """Sort features into cells."""
    return sorted_map(features)[0]


def sorted_map(features: ScanFeatures) -> tuple[FeatureMap, Integers]:
    """Sort features into cells; also return the order (k,) of the points."""
    points = features.points
    low = points.min(axis=0) if len(points) else np.zeros(2)
    cell = np.floor((points - low) / CELL).astype(np.int64).reshape(-1, 2)
    n_cols = int(cell[:, 0].max(initial=0)) + 1
    rows = int(cell[:, 1].max(initial=0)) + 1
    index = cell[:, 1] * n_cols + cell[:, 0]
    order = np.argsort(index, kind="stable")
    cell_start = np.searchsorted(index[order], np.arange(rows * n_cols + 1))
    placed = ScanFeatures(points=points[order], normals=features.normals[order])
    return FeatureMap(features=placed, origin=low, n_cols=n_cols, cell_start=cell_start), order


def has_neighbour(known: FeatureMap, features: ScanFeatures, distance: float) -> Booleans:
    """Mask of features (k,) with a known feature of the same kind within a distance, m."""
    if not len(known.features):
        return np.zeros(len(features), dtype=np.bool_)
    return _has_neighbour(known.cells, features.rows, distance)


@njit(**CACHED)
def _has_neighbour(cells: Cells, rows: Floats, distance: float) -> Booleans:
    out = np.empty(rows.shape[0], dtype=np.bool_)
    place = np.empty(4)
    for i in range(rows.shape[0]):
        place[:] = rows[i, :4]
        out[i] = nearest(cells, place, distance) >= 0
    return out


@callee()
def nearest(cells: Cells, place: Floats, radius: float) -> int:
    """Index of the nearest feature of the same kind within a radius of (x, y, n_x, n_y), or −1."""
    known, origin, n_cols, cell_start = cells
    x, y, nx, ny = place[0], place[1], place[2], place[3]
    is_point = nx == 0.0 and ny == 0.0
    rows = (cell_start.shape[0] - 1) // n_cols
    best, found = radius * radius, -1
    r0 = max(math.floor((y - radius - origin[1]) / CELL), 0)
    r1 = min(math.floor((y + radius - origin[1]) / CELL), rows - 1)
    c0 = max(math.floor((x - radius - origin[0]) / CELL), 0)
    c1 = min(math.floor((x + radius - origin[0]) / CELL), n_cols - 1)
    if c1 < c0:
        return -1
    for r in range(r0, r1 + 1):
        for j in range(cell_start[r * n_cols + c0], cell_start[r * n_cols + c1 + 1]):
            dx, dy = known[j, 0] - x, known[j, 1] - y
            squared = dx * dx + dy * dy
            if squared >= best:
                continue
            mx, my = known[j, 2], known[j, 3]
            if is_point:
                if mx != 0.0 or my != 0.0:
                    continue
            elif nx * mx + ny * my < _MIN_COSINE:
                continue
            best, found = squared, j
    return found
