"""Open list of the grid searches, compiled: a ring of buckets, each of them a stack.

An entry is (item, next entry of its bucket) and the cost at which it was queued. Entries are
recycled, so the list stays in the processor's cache. The caller of :func:`push` ensures the
capacity, because replacing the arrays inside a hot loop costs more than the loop.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, Integers

SQRT2 = math.sqrt(2.0)

SLACK = 1e-10
"""Smallest improvement of a cell's cost, in lowest weights. Rounding differences between sums are
smaller; the error of a path's cost is below 1e-9."""
ANY_STEP = 8
"""Code of the step that led to the start, and to a cell beside other weights."""

_MAX_BUCKETS = 1 << 16


@njit(cache=True)
def bucket_ring(width: float, span: float) -> tuple[Integers, float]:
    """Create (empty heads of a ring for keys up to ``span`` apart, width of a bucket).

    Buckets are wider than requested if there would be too many.
    """
    width = max(width, span / (_MAX_BUCKETS - 4))
    count = 4
    while count * width < span + 2.0 * width:
        count *= 2
    return np.full(count, -1, dtype=np.int64), width


@njit(cache=True)
def double_rows(array: Any) -> Any:
    """Copy of an array with twice the capacity along its first axis."""
    larger = np.empty((2 * array.shape[0], *array.shape[1:]), dtype=array.dtype)
    larger[: array.shape[0]] = array
    return larger


@njit(cache=True)
def push(  # noqa: PLR0917  # a record of arrays is slower in a hot loop
    heads: Integers,
    entries: Integers,
    costs: Floats,
    lists: tuple[int, int],
    slot: int,
    item: int,
    cost: float,
) -> tuple[int, int]:
    """Put ``item`` on the stack of a slot; return (first recycled entry or −1, first unused)."""
    spare, fresh = lists
    if spare >= 0:
        entry, spare = spare, entries[spare, 1]
    else:
        entry, fresh = fresh, fresh + 1
    entries[entry, 0] = item
    entries[entry, 1] = heads[slot]
    costs[entry] = cost
    heads[slot] = entry
    return spare, fresh


@njit(cache=True)
def pop(heads: Integers, entries: Integers, lists: tuple[int, int], slot: int) -> tuple[int, int]:
    """Remove the top entry of a slot; it can be read until the next push."""
    entry = heads[slot]
    heads[slot] = entries[entry, 1]
    entries[entry, 1] = lists[0]
    return entry, lists[1]


@njit(cache=True)
def octile(rows: int, cols: int) -> float:
    """Length of the shortest 8-connected path over free cells."""
    r, c = abs(rows), abs(cols)
    return float(max(r, c) + (SQRT2 - 1.0) * min(r, c))


@njit(cache=True)
def neighbours(stride: int) -> tuple[Any, Integers, Integers]:
    """(index offset modulo 2⁶⁴, row step, column step) of the eight steps, straight ones first.

    The diagonal step i combines the straight steps (i − 4) >> 1 and 2 + (i & 1).
    """
    rows = np.array([-1, 1, 0, 0, -1, -1, 1, 1])
    cols = np.array([0, 0, -1, 1, -1, 1, -1, 1])
    return (rows * stride + cols).astype(np.uint64), rows, cols


@njit(cache=True)
def successors() -> tuple[Integers, Integers]:
    """(worthwhile steps after a step (9, 8), number of them (9,)), where weights are uniform.

    If a cell and its eight neighbours have equal weights, most steps are no cheaper than a path
    that avoids the cell. After a straight step only the one ahead is worthwhile: the others are
    longer than the path around, or as long as the one that goes diagonally first. After a diagonal
    step, the one ahead and the two straight steps beside it are. So no straight step of a cheapest
    path is lost, and a diagonal one only if another order of the steps costs the same; one cheapest
    path is always found, whichever of the equal steps to a cell came first. The same pruning is
    used by jump point search (Harabor and Grastien, 2011).
    """
    ahead = np.zeros((9, 8), dtype=np.int64)
    counts = np.array([1, 1, 1, 1, 3, 3, 3, 3, 8])
    for i in range(4):
        ahead[i, 0] = i
    for i in range(4, 8):
        ahead[i, 0], ahead[i, 1], ahead[i, 2] = (i - 4) >> 1, 2 + (i & 1), i
    ahead[ANY_STEP] = np.arange(8)
    return ahead, counts


@njit(cache=True, inline="always")
def is_uniform(weights: Floats32, u: Any, stride: Any) -> bool:
    """Check that a cell of flattened weights and its eight neighbours have equal weights."""
    weight, one = weights[u], np.uint64(1)
    above, below = u - stride, u + stride
    return bool(
        weights[u - one] == weight
        and weights[u + one] == weight
        and weights[above - one] == weight
        and weights[above] == weight
        and weights[above + one] == weight
        and weights[below - one] == weight
        and weights[below] == weight
        and weights[below + one] == weight
    )
