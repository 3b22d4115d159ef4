"""Cost from one cell to every cell of a grid: exact Dijkstra, compiled.

The steps are those of :mod:`cohelm.planning.grid_search.grid_steps`. The open list is a ring of
buckets that are no wider than the cheapest step, so a cell is final when its bucket is reached. If
rounding breaks that, a cell whose cost decreases later is expanded again: the order affects the
time and never the result.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.array_kernels import NONE, ZERO
from cohelm.arrays import Floats, Floats32
from cohelm.kernels import CACHED
from cohelm.planning.grid_search.bucket_queue import (
    SLACK,
    bucket_ring,
    pop,
    push,
)
from cohelm.planning.grid_search.grid_steps import (
    ANY_STEP,
    SQRT2,
    is_allowed,
    is_uniform,
    neighbours,
    successors,
)
from cohelm.planning.grid_search.weights import Weights


def cost_field(weights: Weights, cell: tuple[int, int], *, limit: float = np.inf) -> Floats:
    """Cost of the cheapest path between a cell (row, column) and every other, in cells.

    Args:
        weights: weights of the grid's cells.
        cell: (row, column), on the grid.
        limit: cells with higher costs stay infinite.

    Returns:
        (rows + 2, cols + 2) with the same border as the weights; inf where no path leads.
    """
    flat, cols = weights.packed.ravel(), weights.packed.shape[1]
    start = (cell[0] + 1) * cols + cell[1] + 1
    capacity, done = flat.size // 32 + 1024, False
    while not done:
        capacity *= 4
        out = np.full(weights.packed.shape, np.inf)
        bounds = weights.lightest, weights.heaviest, limit
        done = _flood(flat, out.ravel(), cols, start, *bounds, capacity)
    return out


@njit(**CACHED)
def _flood(
    weights: Floats32,
    field: Floats,
    stride: int,
    start: int,
    lightest: float,
    heaviest: float,
    limit: float,
    capacity: int,
) -> bool:
    """Fill ``field``, infinite before, from a start; False if the capacity is too small.

    An entry of the open list is 16 · cell + the step that led there; it is stale once the cell has
    another value.
    """
    # The open list: buckets narrower than the cheapest step, and the start in the first one.
    heads, step = bucket_ring(0.99 * lightest, SQRT2 * heaviest)
    entries, costs = np.empty((capacity, 2), dtype=np.int64), np.empty(capacity)
    lists = (NONE, ZERO)
    mask, inverse, slack = heads.shape[0] - 1, 1.0 / step, SLACK * lightest
    offset, _, _ = neighbours(stride)
    ahead, counts = successors()
    free, wide = np.zeros(4, dtype=np.bool_), np.uint64(stride)
    field[start] = 0.0
    lists = push(heads, entries, costs, lists, ZERO, 16 * start + ANY_STEP, 0.0)
    now, waiting = 0, 1
    while waiting > 0:
        # Take the newest entry of the lowest bucket, unless it is stale.
        entry = heads[now & mask]
        if entry < 0:
            now += 1
            continue
        lists = pop(heads, entries, lists, now & mask)
        waiting -= 1
        u = np.uint64(entries[entry, 0] >> 4)
        so_far, came = costs[entry], entries[entry, 0] & 15
        # Expand the cell, then go on to the last neighbour while that is in the lowest bucket.
        going = field[u] == so_far
        while going:
            going = False
            if lists[1] + 8 > capacity:
                return False
            # All steps beside other weights, only the worthwhile ones among uniform weights.
            weight = np.float64(weights[u])
            if came != ANY_STEP and not is_uniform(weights, u, wide):
                came = ANY_STEP
            count, here, before = counts[came], u, so_far
            for n in range(count):
                i = ahead[came, n]
                v = here + offset[i]
                heavy = np.float64(weights[v])
                if not is_allowed(heavy, i, free):
                    continue
                there = before + (0.5 if i < 4 else 0.5 * SQRT2) * (weight + heavy)
                if there >= field[v] - slack or there > limit:
                    continue
                # Queue the neighbour with its lower cost.
                field[v] = there
                bucket = max(now, int(there * inverse))  # below now only by rounding
                if n == count - 1 and bucket == now and count < 8:
                    u, so_far, came, going = v, there, i, True  # without the open list
                else:
                    code = int(np.int64(v)) * 16 + i
                    lists = push(heads, entries, costs, lists, bucket & mask, code, there)
                    waiting += 1
    return True
