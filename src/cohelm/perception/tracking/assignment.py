"""Optimal assignment: pairs of rows and columns at the least total cost, in compiled code."""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED

NO_MATCH = -1
FORBIDDEN = 1e9
"""Cost from which a pair is not made."""


@njit(**CACHED)
def assign(cost: Floats) -> Integers:
    """Column (n,) of each row of ``cost`` (n, d), or ``NO_MATCH``.

    As many pairs as possible are made, at the least total cost; those that cost ``FORBIDDEN`` or
    more are then dropped. Equal totals are resolved as by SciPy's ``linear_sum_assignment``.
    """
    n, d = cost.shape
    column = np.full(n, NO_MATCH)
    # The shorter side looks for partners.
    wide = np.empty((min(n, d), max(n, d)))
    for i in range(n):
        for j in range(d):
            wide[(i, j) if n <= d else (j, i)] = min(cost[i, j], FORBIDDEN)
    partner = _shortest_paths(wide)
    for k in range(len(partner)):
        i, j = (k, partner[k]) if n <= d else (partner[k], k)
        if cost[i, j] < FORBIDDEN:
            column[i] = j
    return column


@njit(**CACHED)
def _shortest_paths(cost: Floats) -> Integers:
    """Column (n,) of each row of ``cost`` (n, d), n ≤ d, by shortest augmenting paths.

    Crouse, On implementing 2D rectangular assignment algorithms, 2016; u and v are dual variables.
    """
    n, d = cost.shape
    u, v = np.zeros(n), np.zeros(d)
    column, row = np.full(n, -1), np.full(d, -1)
    # Of the search from one row: predecessors, path costs, columns left, and what it reached.
    path, length = np.full(d, -1), np.empty(d)
    left = np.empty(d, dtype=np.int64)
    row_seen, column_seen = np.empty(n, dtype=np.bool_), np.empty(d, dtype=np.bool_)
    for first in range(n):
        length[:], row_seen[:], column_seen[:] = np.inf, False, False
        # From the last column on, so that equal costs give the identity.
        for j in range(d):
            left[j] = d - j - 1
        count, least, i, sink = d, 0.0, first, -1
        while sink < 0:
            row_seen[i] = True
            lowest, at = np.inf, 0
            for k in range(count):
                j = left[k]
                reduced = least + cost[i, j] - u[i] - v[j]
                if reduced < length[j]:
                    path[j], length[j] = i, reduced
                # Among equals, a free column ends the path.
                if length[j] < lowest or (length[j] == lowest and row[j] < 0):
                    lowest, at = length[j], k
            least, j = lowest, left[at]
            column_seen[j] = True
            if row[j] < 0:
                sink = j
            else:
                i = row[j]
            count -= 1
            left[at] = left[count]
        _update_duals(u, v, least, first, length, column, row_seen, column_seen)
        # Exchange the pairs along the path.
        j = sink
        while j >= 0:
            i = path[j]
            row[j], column[i], j = i, j, column[i]
    return column


@njit(**CACHED)
def _update_duals(
    u: Floats,
    v: Floats,
    least: float,
    first: int,
    length: Floats,
    column: Integers,
    row_seen: Booleans,
    column_seen: Booleans,
) -> None:
    """Update the dual variables u (n,) and v (d,) after the search from row ``first``, in place."""
    u[first] += least
    for i in range(len(u)):
        if row_seen[i] and i != first:
            u[i] += least - length[column[i]]
    for j in range(len(v)):
        if column_seen[j]:
            v[j] -= least - length[j]
