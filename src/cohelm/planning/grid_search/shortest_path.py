"""Cheapest path over a grid of weights: exact A*, compiled.

The steps and their costs are those of :mod:`cohelm.planning.grid_search.grid_steps`. Three
techniques make the search fast and keep it exact:

- The heuristic of :mod:`cohelm.planning.grid_search.lower_bound` uses walls and weights at a
  quarter or an eighth of the resolution, and is a consistent lower bound.
- The open list is a ring of buckets, each a stack. A cell whose cost decreases later is expanded
  again, and the search ends when no bucket can contain a cheaper path.
- Where weights are uniform, only the steps are taken that can belong to a cheapest path and to no
  equal one (:func:`cohelm.planning.grid_search.grid_steps.successors`), without the open list.

A new cost that is lower by less than ``SLACK`` is ignored: equal paths have sums that differ in the
last digits. The returned cost is summed again along the cells.

The array of costs so far is cached between plans: the operating system fills new memory with zeros
page by page, which takes longer than many searches. After a search, only the pages that it used are
set to zero again.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.array_kernels import NONE, ZERO
from cohelm.arrays import Bytes, Floats, Floats32, Integers
from cohelm.errors import PlanningTimeout
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
    cheapest_parent,
    is_allowed,
    is_uniform,
    neighbours,
    successors,
)
from cohelm.planning.grid_search.lower_bound import bound_at, lower_bound, shift_for
from cohelm.planning.grid_search.weights import GridPath, Weights, path_cost

_AT_START = 5e-324  # cost so far at the start; 0 means "not reached"
_WIDTH = 0.5  # of a bucket, in lowest weights
_FOUND, _NO_PATH, _OUT_OF_BUDGET, _OUT_OF_MEMORY = 0, 1, 2, 3
_PAGE = 9  # a page of the workspace is 2⁹ cells


@dataclass(frozen=True)
class SearchWorkspace:
    """Costs so far of all cells; zero wherever no page is marked as used."""

    reached: Floats
    """Cost so far of each cell, (n,)."""
    used: Bytes
    """Pages of ``reached`` that may not be zero, ((n >> _PAGE) + 1,)."""


_CACHE: deque[SearchWorkspace] = deque(maxlen=1)


def shortest_path(
    weights: Weights,
    start: tuple[int, int],
    goal: tuple[int, int],
    *,
    max_expansions: int | None = None,
) -> GridPath | None:
    """Find the cheapest 8-connected path from ``start`` to ``goal``; None if there is none.

    Args:
        weights: weights of the grid's cells.
        start, goal: (row, column), on the grid.
        max_expansions: budget, cells; None: unlimited.

    Raises:
        PlanningTimeout: if the budget is used up first.
    """
    packed, stride = weights.packed, weights.packed.shape[1]
    begin, end = ((int(row) + 1, int(col) + 1) for row, col in (start, goal))
    if not (np.isfinite(packed[begin]) and np.isfinite(packed[end])):
        return None
    if begin == end:
        return GridPath(cells=np.array([start]), cost=0.0, expansions=0)
    shift, bounds = shift_for(packed.size), (weights.lightest, weights.heaviest)
    nodes = lower_bound(packed, begin, end, *bounds, shift)
    if not np.isfinite(bound_at(nodes.reshape(-1), nodes.shape[1], *begin, shift)):
        return None
    flat, first, last = packed.ravel(), begin[0] * stride + begin[1], end[0] * stride + end[1]
    budget = np.iinfo(np.int64).max if max_expansions is None else max_expansions
    outcome, capacity, work = _OUT_OF_MEMORY, flat.size // 32 + 1024, _acquire(flat.size)
    while outcome == _OUT_OF_MEMORY:
        capacity *= 4
        _clear(work.reached, work.used)
        outcome, expansions = _search(
            flat,
            work.reached,
            work.used,
            nodes,
            shift,
            stride,
            first,
            last,
            *bounds,
            budget,
            capacity,
        )
    cells = _trace(flat, work.reached, stride, first, last) if outcome == _FOUND else None
    _clear(work.reached, work.used)
    _CACHE.append(work)
    if outcome == _OUT_OF_BUDGET:
        raise PlanningTimeout(f"no path within {max_expansions} expanded cells")
    if cells is None:
        return None
    return GridPath(cells=cells, cost=path_cost(weights.packed, cells), expansions=expansions)


def forget_workspace() -> None:
    """Free the cached workspace, for measuring the memory of a plan."""
    _CACHE.clear()


def _acquire(cells: int) -> SearchWorkspace:
    """Take a workspace for that many cells; the cached one if it has the size."""
    try:
        cached = _CACHE.pop()
    except IndexError:
        pass
    else:
        if cached.reached.size == cells:
            return cached
    return SearchWorkspace(
        reached=np.zeros(cells), used=np.zeros((cells >> _PAGE) + 1, dtype=np.uint8)
    )


@njit(**CACHED)
def _clear(reached: Floats, used: Bytes) -> None:
    """Set the used pages to zero."""
    for page in range(used.shape[0]):
        if used[page]:
            reached[page << _PAGE : (page + 1) << _PAGE] = 0.0
            used[page] = 0


@njit(**CACHED)
def _search(
    weights: Floats32,
    reached: Floats,
    used: Bytes,
    nodes: Floats,
    shift: int,
    stride: int,
    start: int,
    goal: int,
    lightest: float,
    heaviest: float,
    budget: int,
    capacity: int,
) -> tuple[int, int]:
    """Fill ``reached`` from the start; return (outcome, expansions).

    A cell's value is 0 if it was not reached, else the cost so far. An entry of the open list is
    16 · cell + the step that led there; it is stale once the cell has another value.
    """
    values, width = nodes.reshape(-1), nodes.shape[1]
    # The open list, with the start in the first bucket; its key is f, the cost over this cell.
    heads, step = bucket_ring(_WIDTH * lightest, 2.0 * SQRT2 * heaviest)
    entries, costs = np.empty((capacity, 2), dtype=np.int64), np.empty(capacity)
    lists = (NONE, ZERO)
    mask, inverse, slack = heads.shape[0] - 1, 1.0 / step, SLACK * lightest
    offset, rows, cols = neighbours(stride)
    ahead, counts = successors()
    free, wide, page = np.zeros(4, dtype=np.bool_), np.uint64(stride), np.uint64(_PAGE)
    base = bound_at(values, width, start // stride, start % stride, shift)
    reached[start], used[start >> _PAGE] = _AT_START, 1
    lists = push(heads, entries, costs, lists, ZERO, 16 * start + ANY_STEP, _AT_START)
    now, last, best, waiting, expansions = 0, 1 << 62, np.inf, 1, 0
    while waiting > 0 and now <= last:
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
        going = reached[u] == so_far
        while going:
            going = False
            expansions += 1
            if expansions > budget:
                return _OUT_OF_BUDGET, expansions
            if lists[1] + 8 > capacity:
                return _OUT_OF_MEMORY, expansions
            row = np.int64(u // wide)
            col = np.int64(u) - row * stride
            # All steps beside other weights, only the worthwhile ones among uniform weights.
            weight = np.float64(weights[u])
            if came != ANY_STEP and not is_uniform(weights, u, wide):
                came = ANY_STEP
            count, here, before = counts[came], u, so_far
            for n in range(count):
                i = n if came == ANY_STEP else ahead[came, n]
                v = here + offset[i]
                heavy = np.float64(weights[v])
                if not is_allowed(heavy, i, free):
                    continue
                there = before + (0.5 if i < 4 else 0.5 * SQRT2) * (weight + heavy)
                # Queue the neighbour if this step is cheaper and can still lead to the best path.
                known = reached[v]
                if known != 0.0 and there >= known - slack:
                    continue
                f = there + bound_at(values, width, row + rows[i], col + cols[i], shift)
                if f >= best:
                    continue
                reached[v] = there
                used[v >> page] = 1
                bucket = max(now, int((f - base) * inverse))  # below now only by rounding
                if v == np.uint64(goal):
                    best, last = f, bucket
                if n == count - 1 and bucket == now and count < 8:
                    u, so_far, came, going = v, there, i, True  # without the open list
                else:
                    code = int(np.int64(v)) * 16 + i
                    lists = push(heads, entries, costs, lists, bucket & mask, code, there)
                    waiting += 1
    return (_FOUND if reached[goal] != 0.0 else _NO_PATH), expansions


@njit(**CACHED)
def _trace(weights: Floats32, reached: Floats, stride: int, start: int, goal: int) -> Integers:
    """Trace the cells (k, 2) from start to goal; each is the cheapest parent of the next."""
    back = [goal]
    u = goal
    while u != start:
        _, u = cheapest_parent(weights, reached, stride, u)
        back.append(u)
    out = np.empty((len(back), 2), dtype=np.int64)
    for i in range(len(back)):
        out[i, 0] = back[len(back) - 1 - i] // stride - 1
        out[i, 1] = back[len(back) - 1 - i] % stride - 1
    return out
