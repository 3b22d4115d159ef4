"""The open list of the grid searches, compiled: a ring of buckets, each of them a stack.

An entry is (what it names, next entry of its bucket) and the cost it was queued at; entries are
recycled, so the list stays in the cache. Who pushes sees to it that there is room; exchanging the
arrays for larger ones inside a hot loop would cost more than the loop does.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, Integers

SQRT2 = math.sqrt(2.0)

SLACK = 1e-10
"""In least weights: what a way must save for a cell to take it. Sums in another order differ by
less; a way so much dearer per step than the cheapest is as cheap to 1e-9."""
ANY = 8
"""The step that led to a cell from outside, and to one on uneven ground."""

_MAX_BUCKETS = 1 << 16


@njit(cache=True)
def ring(width: float, span: float) -> tuple[Integers, float]:
    """(empty heads of a ring that holds keys ``span`` apart, width of a bucket).

    Buckets are wider than asked for where there would be too many.
    """
    width = max(width, span / (_MAX_BUCKETS - 4))
    count = 4
    while count * width < span + 2.0 * width:
        count *= 2
    return np.full(count, -1, dtype=np.int64), width


@njit(cache=True)
def doubled(array: Any) -> Any:
    """An array with as much room again along its first axis."""
    larger = np.empty((2 * array.shape[0], *array.shape[1:]), dtype=array.dtype)
    larger[: array.shape[0]] = array
    return larger


@njit(cache=True)
def push(  # noqa: PLR0917  # a record of arrays costs time in a hot loop
    heads: Integers,
    entries: Integers,
    costs: Floats,
    lists: tuple[int, int],
    slot: int,
    what: int,
    cost: float,
) -> tuple[int, int]:
    """Put ``what`` on the stack of a slot; the lists (first recycled entry or −1, first unused)."""
    spare, fresh = lists
    if spare >= 0:
        entry, spare = spare, entries[spare, 1]
    else:
        entry, fresh = fresh, fresh + 1
    entries[entry, 0] = what
    entries[entry, 1] = heads[slot]
    costs[entry] = cost
    heads[slot] = entry
    return spare, fresh


@njit(cache=True)
def drop(heads: Integers, entries: Integers, lists: tuple[int, int], slot: int) -> tuple[int, int]:
    """Recycle the top entry of a slot, which can be read until the next push."""
    entry = heads[slot]
    heads[slot] = entries[entry, 1]
    entries[entry, 1] = lists[0]
    return entry, lists[1]


@njit(cache=True)
def octile(rows: int, cols: int) -> float:
    """The length of the shortest 8-connected way over free cells."""
    r, c = abs(rows), abs(cols)
    return float(max(r, c) + (SQRT2 - 1.0) * min(r, c))


@njit(cache=True)
def neighbours(stride: int) -> tuple[Any, Integers, Integers]:
    """(index offset modulo 2⁶⁴, row step, column step) of the eight, straight ones first.

    The diagonal one i goes in the directions of the straight ones (i − 4) >> 1 and 2 + (i & 1).
    """
    rows = np.array([-1, 1, 0, 0, -1, -1, 1, 1])
    cols = np.array([0, 0, -1, 1, -1, 1, -1, 1])
    return (rows * stride + cols).astype(np.uint64), rows, cols


@njit(cache=True)
def successors() -> tuple[Integers, Integers]:
    """(steps worth taking after a step (9, 8), number of them (9,)), on even ground.

    Where a cell and its eight neighbours weigh the same, most steps are no cheaper than a way that
    does without the cell. After a straight step only the one ahead is worth taking: the others are
    longer than the way round, or as long as the one that goes diagonally first. After a diagonal
    one the two straight ones beside it and the one ahead are. A straight step of a cheapest way is
    thus never left out, nor a diagonal one unless a diagonal and a straight one cost the same; so
    one cheapest way is always found, whichever of the equal steps to a cell came first.
    """
    ahead = np.zeros((9, 8), dtype=np.int64)
    counts = np.array([1, 1, 1, 1, 3, 3, 3, 3, 8])
    for i in range(4):
        ahead[i, 0] = i
    for i in range(4, 8):
        ahead[i, 0], ahead[i, 1], ahead[i, 2] = (i - 4) >> 1, 2 + (i & 1), i
    ahead[ANY] = np.arange(8)
    return ahead, counts


@njit(cache=True, inline="always")
def is_even(weights: Floats32, u: Any, stride: Any) -> bool:
    """Whether a cell of flattened weights and its eight neighbours weigh the same."""
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
