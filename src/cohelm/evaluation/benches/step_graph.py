"""The planner's steps as a graph, for SciPy."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import coo_array

from cohelm.arrays import Floats32


def step_graph(weights: Floats32) -> Any:
    """An undirected CSR graph of a grid's steps: row-major cells, length · mean weight.

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
