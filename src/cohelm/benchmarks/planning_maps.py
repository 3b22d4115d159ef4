"""Maps of the planning benchmark, and the same grid as a graph for SciPy."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy.sparse import coo_array

from cohelm.arrays import Floats32
from cohelm.maps import FREE, OCCUPIED, MapWarning, OccupancyGrid, read_map
from cohelm.planning.costmap.costmap import Costmap
from cohelm.planning.costmap.patch import INSCRIBED

_RESOLUTION, _ROOM, _DOOR = 0.05, 100, 24  # m, cells, cells


def floor(size: int, seed: int) -> OccupancyGrid:
    """Floor of square rooms in rows, a door in every wall, boxes in the rooms."""
    rng = np.random.default_rng(seed)
    data = np.full((size, size), FREE, dtype=np.int8)
    for line in range(0, size, _ROOM):
        data[line : line + 3, :] = data[:, line : line + 3] = OCCUPIED
    for line in range(0, size, _ROOM):
        for room in range(0, size, _ROOM):
            across, along = room + rng.integers(10, _ROOM - _DOOR - 10, size=2)
            if line > 0:
                data[line : line + 3, across : across + _DOOR] = FREE
                data[along : along + _DOOR, line : line + 3] = FREE
            r, c = rng.integers(30, _ROOM - 45, size=2)
            data[line + r : line + r + 15, room + c : room + c + 15] = OCCUPIED
    data[[0, -1], :] = data[:, [0, -1]] = OCCUPIED
    return OccupancyGrid(data=data, resolution=_RESOLUTION, X_MG=np.zeros(3))


def scaled(file: Path, size: int) -> OccupancyGrid:
    """Scale a map to ``size`` × ``size`` cells by nearest neighbours; the resolution is kept."""
    with warnings.catch_warnings():  # ``create`` has shown them
        warnings.simplefilter("ignore", MapWarning)
        grid = read_map(file)
    data = cv2.resize(grid.data.view(np.uint8), (size, size), interpolation=cv2.INTER_NEAREST_EXACT)
    return replace(grid, data=data.view(np.int8))


def far_apart(costmap: Costmap) -> tuple[tuple[int, int], tuple[int, int]]:
    """Two far corners of the largest connected component of a costmap."""
    free = (costmap.cost < INSCRIBED).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    if len(stats) < 2:
        raise ValueError("this map has no free space for the chair")
    cells = np.argwhere(labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))
    sums = cells.sum(axis=1)
    (r0, c0), (r1, c1) = cells[[int(sums.argmin()), int(sums.argmax())]].tolist()
    return (r0, c0), (r1, c1)


def step_graph(weights: Floats32) -> Any:
    """Undirected CSR graph of a grid's steps for SciPy: row-major cells, length · mean weight.

    No step cuts the corner of a blocked cell.

    Args:
        weights: (rows, cols), infinite where blocked.
    """
    rows, cols = weights.shape
    w = np.pad(weights.astype(np.float64), 1, constant_values=np.inf)
    index = np.full(w.shape, -1)
    index[1:-1, 1:-1] = np.arange(rows * cols).reshape(rows, cols)
    here = (slice(1, -1), slice(1, -1))
    sources, targets, costs = [], [], []
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        there = (slice(1 + dr, rows + 1 + dr), slice(1 + dc, cols + 1 + dc))
        open_ = np.isfinite(w[here]) & np.isfinite(w[there])
        if dr and dc:
            open_ &= np.isfinite(w[1 + dr : rows + 1 + dr, 1:-1])
            open_ &= np.isfinite(w[1:-1, 1 + dc : cols + 1 + dc])
        sources.append(index[here][open_])
        targets.append(index[there][open_])
        costs.append(np.hypot(dr, dc) * (w[here][open_] + w[there][open_]) / 2.0)
    size = rows * cols
    entries = (np.concatenate(costs), (np.concatenate(sources), np.concatenate(targets)))
    return coo_array(entries, shape=(size, size)).tocsr()
