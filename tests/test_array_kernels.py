"""Kernels that take the place of numba's own give the same results, bit for bit."""

import numpy as np
import pytest

from cohelm.array_kernels import copy_row, members_by_label, stable_order


@pytest.mark.parametrize("n", [0, 1, 2, 3, 17, 64, 1000])
def test_order_is_that_of_numpy(n):
    rng = np.random.default_rng(n)
    values = rng.integers(0, max(n // 3, 1), n) * 0.5  # many ties
    values[rng.random(n) < 0.1] = np.nan
    values[rng.random(n) < 0.05] = np.inf
    np.testing.assert_array_equal(stable_order(values), np.argsort(values, kind="stable"))


@pytest.mark.parametrize("n", [0, 1, 50])
def test_members_are_sorted_by_label_and_index(n):
    labels = np.random.default_rng(n).integers(-1, 5, n)
    members, first = members_by_label(labels, 6)
    assert first.shape == (7,)
    assert first[-1] == members.size == (labels >= 0).sum()
    for k in range(6):
        np.testing.assert_array_equal(members[first[k] : first[k + 1]], np.flatnonzero(labels == k))


def test_a_row_is_copied():
    target = np.zeros((2, 4))
    copy_row(target[1], np.arange(3.0))
    np.testing.assert_array_equal(target, [[0, 0, 0, 0], [0, 1, 2, 0]])
