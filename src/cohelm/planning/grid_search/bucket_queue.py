"""Open list of the grid searches, compiled: a ring of buckets, each of them a stack.

An entry is (item, next entry of its bucket) and the cost at which it was queued. Entries are
recycled, so the list stays in the processor's cache. The caller of :func:`push` ensures the
capacity, because replacing the arrays inside a hot loop costs more than the loop.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cohelm.array_kernels import copy_row
from cohelm.arrays import Floats, Integers
from cohelm.kernels import callee

SLACK = 1e-10
"""Smallest improvement of a cell's cost, in lowest weights. Rounding differences between sums are
smaller; the error of a path's cost is below 1e-9."""

_MAX_BUCKETS = 1 << 16


@callee()
def bucket_ring(width: float, span: float) -> tuple[Integers, float]:
    """Create (empty heads of a ring for keys up to ``span`` apart, width of a bucket).

    Buckets are wider than requested if there would be too many.
    """
    width = max(width, span / (_MAX_BUCKETS - 4))
    count = 4
    while count * width < span + 2.0 * width:
        count *= 2
    return np.full(count, -1, dtype=np.int64), width


@callee()
def double_rows(array: Any) -> Any:
    """Copy of an array with twice the capacity along its first axis."""
    larger = np.empty((2 * array.shape[0], *array.shape[1:]), dtype=array.dtype)
    copy_row(larger.reshape(-1), array.reshape(-1))
    return larger


@callee()
def push(
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


@callee()
def pop(heads: Integers, entries: Integers, lists: tuple[int, int], slot: int) -> tuple[int, int]:
    """Remove the top entry of a slot; it can be read until the next push."""
    entry = heads[slot]
    heads[slot] = entries[entry, 1]
    entries[entry, 1] = lists[0]
    return entry, lists[1]
