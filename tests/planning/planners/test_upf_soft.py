"""The field as a discount in steps, which keep the search short."""

from __future__ import annotations

import numpy as np

from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.planners.upf import STEPS, discounted

DISCOUNT = 0.5
FLOOR = (1000, 400)


def _field() -> np.ndarray:
    """A valley far down a long floor, wider than the floor is."""
    rows, cols = FLOOR
    y = np.arange(rows, dtype=np.float32)[:, None] / rows - 0.9
    x = np.arange(cols, dtype=np.float32) / cols - 0.3
    return np.exp(-0.8 * (np.square(y) + np.square(x)))


def _even() -> Weights:
    return Weights.of(np.ones(FLOOR, dtype=np.float32))


def test_a_discount_is_off_by_no_more_than_half_a_step():
    field = _field()
    exact = 1.0 - DISCOUNT * field / field.max()
    found = discounted(_even(), field, DISCOUNT).packed[1:-1, 1:-1]
    assert np.abs(found - exact).max() <= 0.5 * DISCOUNT / STEPS + 1e-6


def test_the_search_stays_short_where_the_discount_falls_off_smoothly():
    # Without steps it expands each cell of this floor more than twenty times.
    rows, cols = FLOOR
    weights = discounted(_even(), _field(), DISCOUNT)
    found = shortest_path(weights, (5, 5), (rows - 5, cols - 5))
    assert found is not None
    assert found.expansions < 2 * rows * cols


def test_what_the_lightest_cell_weighs_is_not_overstated():
    weights = discounted(_even(), _field(), DISCOUNT)
    assert weights.lightest <= weights.packed.min()
