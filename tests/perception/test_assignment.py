"""The assignment against SciPy's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from cohelm.perception.tracking.association import FORBIDDEN, NO_MATCH, assign


def by_scipy(cost):
    rows, cols = linear_sum_assignment(np.minimum(cost, FORBIDDEN))
    made = cost[rows, cols] < FORBIDDEN
    column = np.full(len(cost), NO_MATCH)
    column[rows[made]] = cols[made]
    return column.tolist()


@settings(max_examples=200, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    shape=st.tuples(st.integers(0, 8), st.integers(0, 8)),
    whole=st.booleans(),
    forbidden=st.floats(0.0, 1.0),
)
def test_makes_the_same_pairs_as_scipy_among_equals_too(seed, shape, whole, forbidden):
    # small whole numbers have many assignments of the same total
    rng = np.random.default_rng(seed)
    cost = rng.integers(0, 4, shape).astype(float) if whole else 5.0 * rng.standard_normal(shape)
    cost = np.where(rng.random(shape) < forbidden, FORBIDDEN, cost)
    assert assign(cost).tolist() == by_scipy(cost)


@pytest.mark.parametrize("shape", [(3, 3), (2, 4), (4, 2)])
def test_of_equal_costs_the_first_ones_pair(shape):
    rows, cols = shape
    want = [row if row < cols else NO_MATCH for row in range(rows)]
    assert assign(np.ones(shape)).tolist() == want
    assert assign(np.full(shape, FORBIDDEN)).tolist() == [NO_MATCH] * rows
