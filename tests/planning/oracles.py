"""Other people's shortest paths, and grids to try them on."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra


def random_weights(rng, rows, cols, share_blocked=0.25):
    """Float32 weights over three decades, some cells blocked."""
    weights = np.exp(rng.uniform(-2.0, 5.0, (rows, cols))).astype(np.float32)
    weights[rng.random((rows, cols)) < share_blocked] = np.inf
    return weights


def graph(weights):
    """The same graph as the planner's, for scipy: no step cuts the corner of a blocked cell."""
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


def least_cost(weights, start, goal):
    """The least cost from start to goal by scipy's dijkstra; inf where there is no way."""
    cols = weights.shape[1]
    costs = dijkstra(graph(weights), directed=False, indices=start[0] * cols + start[1])
    return costs[goal[0] * cols + goal[1]]
