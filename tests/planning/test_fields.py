"""A field says of every cell what scipy's Dijkstra says, however many seeds there are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from cohelm.evaluation.benches.step_graph import step_graph
from cohelm.planning.fields import cost_field, cost_field_from, descend
from cohelm.planning.search import Weights, path_cost, shortest_path

from .oracles import random_weights


def field_by_scipy(weights, initial):
    """One more node, from which each seed is reached at its initial cost."""
    size = weights.size
    seeds = np.flatnonzero(np.isfinite(initial.ravel()) & np.isfinite(weights.ravel()))
    steps = step_graph(weights).tocoo()
    source = np.full(len(seeds), size)
    costs = np.maximum(initial.ravel()[seeds], 1e-300)  # scipy takes a 0 for no edge
    joined = coo_array(
        (
            np.concatenate([steps.data, steps.data, costs]),
            (
                np.concatenate([steps.row, steps.col, source]),
                np.concatenate([steps.col, steps.row, seeds]),
            ),
        ),
        shape=(size + 1, size + 1),
    ).tocsr()
    return dijkstra(joined, indices=size)[:-1].reshape(weights.shape)


def draw(rng, rows, cols):
    """Weights and initial costs, some of which are dominated by their neighbours'."""
    weights = random_weights(rng, rows, cols, share_blocked=rng.uniform(0.0, 0.4))
    initial = np.where(
        rng.random((rows, cols)) < rng.choice([0.01, 0.2, 1.0]),
        rng.uniform(0.0, rng.choice([1.0, 1e3]), (rows, cols)),
        np.inf,
    )
    return weights, initial


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 20), cols=st.integers(1, 20))
def test_is_what_dijkstra_says(seed, rows, cols):
    weights, initial = draw(np.random.default_rng(seed), rows, cols)
    field = cost_field(Weights.of(weights), initial)
    np.testing.assert_allclose(field[1:-1, 1:-1], field_by_scipy(weights, initial), rtol=1e-9)
    assert np.isinf(field[[0, -1]]).all()
    assert np.isinf(field[:, [0, -1]]).all()


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_way_down_costs_what_the_field_says(seed):
    rng = np.random.default_rng(seed)
    given_weights, initial = draw(rng, 15, 18)
    weights = Weights.of(given_weights)
    field = cost_field(weights, initial)
    for cell in np.argwhere(np.isfinite(field[1:-1, 1:-1]))[::7]:
        cells = descend(weights, field, initial, tuple(cell))
        assert tuple(cells[-1]) == tuple(cell)
        cost = initial[tuple(cells[0])] + path_cost(weights.packed, cells)
        assert cost == pytest.approx(field[cell[0] + 1, cell[1] + 1], rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_one_seed_agrees_with_the_search(seed):
    rng = np.random.default_rng(seed)
    weights = Weights.of(random_weights(rng, 40, 50, share_blocked=0.3))
    start = tuple(np.argwhere(np.isfinite(weights.packed[1:-1, 1:-1]))[0])
    field = cost_field_from(weights, start)
    for goal in rng.integers(0, 40, (20, 2)):
        found = shortest_path(weights, start, tuple(goal))
        there = field[goal[0] + 1, goal[1] + 1]
        assert np.isinf(there) if found is None else found.cost == pytest.approx(there, rel=1e-12)


def test_the_limit_leaves_out_what_costs_more():
    weights, initial = draw(np.random.default_rng(3), 30, 30)
    whole = cost_field(Weights.of(weights), initial)
    limit = float(np.median(whole[np.isfinite(whole)]))
    cut = cost_field(Weights.of(weights), initial, limit=limit)
    assert (cut == np.where(whole <= limit, whole, np.inf)).all()


def test_without_seeds_nothing_is_reached():
    weights = Weights.of(np.ones((4, 5), dtype=np.float32))
    assert np.isinf(cost_field(weights, np.full((4, 5), np.inf))).all()


@pytest.mark.parametrize("bad", [-1.0, np.nan])
def test_initial_costs_must_be_costs(bad):
    weights = Weights.of(np.ones((4, 5), dtype=np.float32))
    initial = np.full((4, 5), np.inf)
    initial[2, 2] = bad
    with pytest.raises(ValueError, match="initial"):
        cost_field(weights, initial)


def test_a_cell_that_nothing_reaches_has_no_way_down():
    weights = Weights.of(np.ones((4, 5), dtype=np.float32))
    initial = np.full((4, 5), np.inf)
    with pytest.raises(ValueError, match="no way"):
        descend(weights, cost_field(weights, initial), initial, (1, 1))
