"""The bounds of the layers are consistent along steps and at via points."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.planning.grid_search.lower_bound import COARSE_SHIFT, bound_at
from cohelm.planning.grid_search.via_points import ViaChain, via_graph
from cohelm.planning.grid_search.via_search import layer_bounds
from cohelm.planning.grid_search.weights import Weights

from .oracles import random_weights


def draw(rng):
    """Rough or even weights, a free goal, and chains of points, some of them off the grid."""
    rows, cols = rng.integers(2, 90, 2)
    weights = random_weights(rng, rows, cols, share_blocked=rng.uniform(0.0, 0.3))
    if rng.random() < 0.5:
        weights = np.where(np.isfinite(weights), np.float32(rng.choice([1.0, 5.0])), weights)
    goal = tuple(rng.integers(0, [rows, cols]))
    weights[goal] = 1.0
    chains = tuple(
        ViaChain(
            points=rng.uniform(-20.0, 110.0, (rng.integers(1, 4), 2)),
            price=float(np.exp(rng.uniform(-2.0, 4.0))),
        )
        for _ in range(rng.integers(1, 4))
    )
    return Weights.of(weights), goal, via_graph(chains, (int(rows), int(cols)))


def bounds_everywhere(weights, goal, graph, most):
    """(layers, rows, cols) of the packed grid, zero at the goal of the last."""
    packed, end = weights.packed, (int(goal[0]) + 1, int(goal[1]) + 1)
    light = weights.lightest, weights.heaviest
    nodes = layer_bounds(packed, graph, end, *light, most)
    width, (rows, cols) = nodes.shape[2], packed.shape
    h = np.array(
        [
            [
                [bound_at(layer.reshape(-1), width, r, c, COARSE_SHIFT) for c in range(cols)]
                for r in range(rows)
            ]
            for layer in nodes
        ]
    )
    return h - h[-1][end]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_falls_by_no_more_than_is_paid(seed):
    rng = np.random.default_rng(seed)
    weights, goal, graph = draw(rng)
    most = float(rng.choice([1e3, 1e5]))
    h, w = bounds_everywhere(weights, goal, graph, most), weights.packed.astype(float)
    inner, (rows, cols) = slice(1, -1), w.shape
    free = np.isfinite(w[inner, inner])
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        there = (slice(1 + dr, rows - 1 + dr), slice(1 + dc, cols - 1 + dc))
        step = np.hypot(dr, dc) * (w[inner, inner] + w[there]) / 2.0
        both = np.isfinite(step)
        falls = np.abs(h[:, inner, inner] - h[:, *there])[:, both]
        assert (falls <= step[both] * (1.0 + 1e-9) + 1e-9).all()
    cells = np.stack(np.indices(free.shape), axis=-1)
    for layer, (begin, end) in enumerate(zip(graph.edges_from, graph.edges_from[1:], strict=False)):
        for then, point in graph.edges[begin:end]:
            row, col, price, beyond = graph.points[point]
            far = np.hypot(*np.moveaxis(cells - [row, col], -1, 0))
            saved = (h[layer] - h[then])[inner, inner][free]
            paid = price * np.maximum(far - beyond, 0.0)[free]
            assert (saved <= paid + 1e-9 * (1.0 + np.abs(saved) + most)).all()


def test_knows_what_is_left_of_the_way():
    # From one end of a corridor to a point at the other and back, but for the squares' size.
    weights = Weights.of(np.full((9, 400), 2.0, dtype=np.float32))
    graph = via_graph((ViaChain(points=np.array([[4.0, 390.0]]), price=10.0),), (9, 400))
    h = bounds_everywhere(weights, (4, 8), graph, 1e5)
    assert 2.0 * (2 * 382 - 2 * 12) <= h[0, 5, 9] <= 2.0 * 2 * 382
