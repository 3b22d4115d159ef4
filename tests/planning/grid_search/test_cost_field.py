"""A cost field equals SciPy's Dijkstra and the A* search."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from cohelm.benchmarks.planning import step_graph
from cohelm.planning.grid_search.cost_field import cost_field
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import Weights

from .oracles import random_weights


def draw(rng, rows, cols):
    """Weights, and one cell that is passable."""
    weights = random_weights(rng, rows, cols, share_blocked=rng.uniform(0.0, 0.4))
    start = int(rng.integers(rows)), int(rng.integers(cols))
    weights[start] = 1.0
    return weights, start


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 20), cols=st.integers(1, 20))
def test_equals_dijkstra(seed, rows, cols):
    weights, start = draw(np.random.default_rng(seed), rows, cols)
    field = cost_field(Weights.of(weights), start)
    costs = dijkstra(step_graph(weights), directed=False, indices=start[0] * cols + start[1])
    np.testing.assert_allclose(field[1:-1, 1:-1], costs.reshape(rows, cols), rtol=1e-9)
    assert np.isinf(field[[0, -1]]).all()
    assert np.isinf(field[:, [0, -1]]).all()


@pytest.mark.parametrize("seed", range(5))
def test_agrees_with_the_search(seed):
    rng = np.random.default_rng(seed)
    weights = Weights.of(random_weights(rng, 40, 50, share_blocked=0.3))
    start = tuple(np.argwhere(np.isfinite(weights.packed[1:-1, 1:-1]))[0])
    field = cost_field(weights, start)
    for goal in rng.integers(0, 40, (20, 2)):
        found = shortest_path(weights, start, tuple(goal))
        there = field[goal[0] + 1, goal[1] + 1]
        assert np.isinf(there) if found is None else found.cost == pytest.approx(there, rel=1e-12)


def test_cells_above_the_limit_stay_infinite():
    weights, start = draw(np.random.default_rng(3), 30, 30)
    whole = cost_field(Weights.of(weights), start)
    limit = float(np.median(whole[np.isfinite(whole)]))
    cut = cost_field(Weights.of(weights), start, limit=limit)
    assert (cut == np.where(whole <= limit, whole, np.inf)).all()
