"""Shortest paths by SciPy, and random weights for them."""

import numpy as np
from scipy.sparse.csgraph import dijkstra

from cohelm.benchmarks.planning import step_graph as graph


def random_weights(rng, rows, cols, share_blocked=0.25):
    """Float32 weights over three decades, some cells blocked."""
    weights = np.exp(rng.uniform(-2.0, 5.0, (rows, cols))).astype(np.float32)
    weights[rng.random((rows, cols)) < share_blocked] = np.inf
    return weights


def least_cost(weights, start, goal):
    """The least cost from start to goal by scipy's dijkstra; inf where there is no way."""
    cols = weights.shape[1]
    costs = dijkstra(graph(weights), directed=False, indices=start[0] * cols + start[1])
    return costs[goal[0] * cols + goal[1]]
