"""The lower bound is consistent, and exact on free floor."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.planning.grid_search.cost_field import cost_field
from cohelm.planning.grid_search.lower_bound import COARSE_SHIFT, bound_at, lower_bound
from cohelm.planning.grid_search.weights import Weights

from .oracles import random_weights


def bound_everywhere(weights, start, goal, shift=COARSE_SHIFT):
    """The bound at every cell of the packed grid, zero at the goal."""
    packed = weights.packed
    begin, end = (start[0] + 1, start[1] + 1), (goal[0] + 1, goal[1] + 1)
    nodes = lower_bound(packed, begin, end, weights.lightest, weights.heaviest, shift)
    flat, width = nodes.reshape(-1), nodes.shape[1]
    rows, cols = packed.shape
    out = np.array([[bound_at(flat, width, r, c, shift) for c in range(cols)] for r in range(rows)])
    return out - out[end]


def draw(rng):
    """Rough or blocky weights with some cells or blocks blocked, and two free cells."""
    rows, cols = rng.integers(2, 60, 2)
    if rng.random() < 0.5:
        weights = random_weights(rng, rows, cols, share_blocked=rng.uniform(0.0, 0.3))
    else:
        blocks = rng.choice([1.0, 2.0, 9.0, np.inf], (rows // 9 + 1, cols // 9 + 1))
        weights = np.kron(blocks, np.ones((9, 9)))[:rows, :cols].astype(np.float32)
    free = np.argwhere(np.isfinite(weights))
    if not len(free):
        weights[0, 0], free = 1.0, np.zeros((1, 2), dtype=int)
    start, goal = rng.choice(free, 2)
    return Weights.of(weights), tuple(start), tuple(goal)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), shift=st.integers(1, COARSE_SHIFT))
def test_falls_along_no_step_by_more_than_it_costs(seed, shift):
    weights, start, goal = draw(np.random.default_rng(seed))
    h, w = bound_everywhere(weights, start, goal, shift), weights.packed.astype(float)
    if not np.isfinite(h[start[0] + 1, start[1] + 1]):
        assert np.isinf(cost_field(weights, goal)[start[0] + 1, start[1] + 1])
        return
    inner, (rows, cols) = slice(1, -1), w.shape
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        there = (slice(1 + dr, rows - 1 + dr), slice(1 + dc, cols - 1 + dc))
        step = np.hypot(dr, dc) * (w[inner, inner] + w[there]) / 2.0
        both = np.isfinite(h[inner, inner]) & np.isfinite(h[there]) & np.isfinite(step)
        falls = np.abs(h[inner, inner][both] - h[there][both])
        assert (falls <= step[both] * (1.0 + 1e-9) + 1e-9).all()


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), shift=st.integers(1, COARSE_SHIFT))
def test_is_no_more_than_the_cost(seed, shift):
    weights, start, goal = draw(np.random.default_rng(seed))
    h, cost = bound_everywhere(weights, start, goal, shift), cost_field(weights, goal)
    reached = np.isfinite(cost)
    if reached[start[0] + 1, start[1] + 1]:
        assert (h[reached] <= cost[reached] * (1.0 + 1e-9) + 1e-9).all()


@pytest.mark.parametrize("goal", [(7, 7), (23, 55), (39, 15)])
def test_is_the_octile_distance_on_an_empty_floor(goal):
    # The goals lie on nodes: eight cells apart, counted with the border.
    weights = Weights.of(np.full((80, 90), 3.0, dtype=np.float32))
    h = bound_everywhere(weights, (79, 89), goal)[1:-1, 1:-1]
    r, c = np.abs(np.indices(h.shape) - np.array(goal)[:, None, None])
    octile = 3.0 * (np.maximum(r, c) + (np.sqrt(2.0) - 1.0) * np.minimum(r, c))
    np.testing.assert_allclose(h, octile, rtol=1e-12, atol=1e-12)


def test_says_where_no_way_leads():
    weights = np.ones((60, 60), dtype=np.float32)
    weights[:, 20:40] = np.inf  # thicker than two squares
    h = bound_everywhere(Weights.of(weights), (5, 5), (50, 50))
    assert not np.isfinite(h[6, 6])
