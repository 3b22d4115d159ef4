"""What it costs to reach every cell of a grid: exact Dijkstra, compiled.

The steps are those of :mod:`cohelm.planning.search`: 8-connected, length · (w_u + w_v) / 2, and no
corner of a blocked cell cut. The open list is a ring of buckets that are no wider than the cheapest
step, so a cell is final when its bucket is reached. Where rounding breaks that by a hair, a cell
that becomes cheaper afterwards is expanded again: the order costs time, never exactness.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.planning.buckets import (
    ANY,
    SLACK,
    SQRT2,
    drop,
    is_even,
    neighbours,
    push,
    ring,
    successors,
)
from cohelm.planning.search import Weights

_SORTING = 1 << 16  # buckets that the seeds are put in order with


def cost_field(weights: Weights, initial: Floats, *, limit: float = np.inf) -> Floats:
    """The least of (initial cost of a seed + cost of the way from it) for every cell, in cells.

    Args:
        weights: of the grid's cells.
        initial: (rows, cols), what the way to a cell costs from outside; inf where none leads.
            Blocked cells are no seeds.
        limit: cells that cost more are left infinite.

    Returns:
        (rows + 2, cols + 2) with the same border as the weights; inf where no way leads.

    Raises:
        ValueError: if an initial cost is negative or NaN, or the shapes differ.
    """
    rows, cols = weights.packed.shape
    if initial.shape != (rows - 2, cols - 2):
        raise ValueError(f"initial costs {initial.shape} on a grid {(rows - 2, cols - 2)}")
    seeds, least = _in_order(weights.packed, initial, limit)
    if not least >= 0.0:
        raise ValueError("initial costs must not be negative or NaN")
    costs = initial.ravel()[(seeds // cols - 1) * (cols - 2) + seeds % cols - 1]
    return _field(weights, seeds, costs, limit)


def cost_field_from(weights: Weights, cell: tuple[int, int], *, limit: float = np.inf) -> Floats:
    """The cost of the cheapest way between a cell (row, column) and every other; see cost_field."""
    cols = weights.packed.shape[1]
    seed = np.array([(cell[0] + 1) * cols + cell[1] + 1])
    return _field(weights, seed, np.zeros(1), limit)


def descend(weights: Weights, field: Floats, initial: Floats, cell: tuple[int, int]) -> Integers:
    """The way (k, 2) from the seed that a cell is reached from to that cell, both included.

    Args:
        weights, initial: that the field was made of.
        field: by :func:`cost_field`.
        cell: (row, column), where the field is finite.

    Raises:
        ValueError: if the field is infinite there.
    """
    cols = weights.packed.shape[1]
    last = (cell[0] + 1) * cols + cell[1] + 1
    if not np.isfinite(field.ravel()[last]):
        raise ValueError(f"no way leads to {cell}")
    return _descend(weights.packed.ravel(), field.ravel(), initial.ravel(), cols, last)


def _field(weights: Weights, seeds: Integers, costs: Floats, limit: float) -> Floats:
    flat, cols = weights.packed.ravel(), weights.packed.shape[1]
    room, done = flat.size // 32 + 1024, False
    while not done:
        room *= 4
        out = np.full(weights.packed.shape, np.inf)
        done = _flood(
            flat, out.ravel(), cols, seeds, costs, weights.lightest, weights.heaviest, limit, room
        )
    return out


@njit(cache=True)
def _in_order(weights: Floats32, initial: Floats, limit: float) -> tuple[Integers, float]:
    """(packed indices of the seeds, roughly by rising cost; the least cost, NaN if one is)."""
    rows, cols = initial.shape
    low, high, count = np.inf, -np.inf, 0
    for r in range(rows):
        for c in range(cols):
            cost = initial[r, c]
            if np.isnan(cost):
                return np.empty(0, dtype=np.int64), np.nan
            if cost < np.inf and cost <= limit and weights[r + 1, c + 1] < np.inf:
                low, high = min(low, cost), max(high, cost)
                count += 1
    scale = (_SORTING - 1) / (high - low) if high > low else 0.0
    ends = np.zeros(_SORTING + 1, dtype=np.int64)
    seeds = np.empty(count, dtype=np.int64)
    for filling in range(2):
        for r in range(rows):
            for c in range(cols):
                cost = initial[r, c]
                if cost < np.inf and cost <= limit and weights[r + 1, c + 1] < np.inf:
                    bucket = int((cost - low) * scale)
                    if filling == 0:
                        ends[bucket + 1] += 1
                    else:
                        seeds[ends[bucket]] = (r + 1) * (cols + 2) + c + 1
                        ends[bucket] += 1
        if filling == 0:
            for i in range(_SORTING):
                ends[i + 1] += ends[i]
    return seeds, low


@njit(cache=True)
def _flood(  # noqa: PLR0912, PLR0913, PLR0917  # one hot loop
    weights: Floats32,
    field: Floats,
    stride: int,
    seeds: Integers,
    first: Floats,
    lightest: float,
    heaviest: float,
    limit: float,
    room: int,
) -> bool:
    """Lower ``field``, infinite before, from seeds at their first costs; whether there was room.

    Seeds join when their bucket comes. An entry of the open list is 16 · cell + the step that led
    there; it is stale once the cell has another value.
    """
    heads, step = ring(0.99 * lightest, SQRT2 * heaviest)
    entries, costs, lists = np.empty((room, 2), dtype=np.int64), np.empty(room), (-1, 0)
    mask, inverse, slack = heads.shape[0] - 1, 1.0 / step, SLACK * lightest
    offset, _, _ = neighbours(stride)
    ahead, counts = successors()
    free, wide = np.zeros(4, dtype=np.bool_), np.uint64(stride)
    joined, now, waiting = 0, 0, 0
    while waiting > 0 or joined < seeds.shape[0]:
        if waiting == 0:
            now = max(now, int(first[joined] * inverse))
        while joined < seeds.shape[0] and int(first[joined] * inverse) <= now:
            v, there = np.uint64(seeds[joined]), first[joined]
            joined += 1
            if there < field[v]:
                if lists[1] + 8 > room:
                    return False
                field[v] = there
                code = int(np.int64(v)) * 16 + ANY
                lists = push(heads, entries, costs, lists, now & mask, code, there)
                waiting += 1
        entry = heads[now & mask]
        if entry < 0:
            now += 1
            continue
        lists = drop(heads, entries, lists, now & mask)
        waiting -= 1
        u = np.uint64(entries[entry, 0] >> 4)
        so_far, came = costs[entry], entries[entry, 0] & 15
        going = field[u] == so_far
        while going:
            going = False
            if lists[1] + 8 > room:
                return False
            weight = np.float64(weights[u])
            if came != ANY and not is_even(weights, u, wide):
                came = ANY
            count, here, before = counts[came], u, so_far
            for n in range(count):
                i = ahead[came, n]
                v = here + offset[i]
                heavy = np.float64(weights[v])
                if i < 4:
                    free[i] = heavy < np.inf
                    if not free[i]:
                        continue
                    there = before + 0.5 * (weight + heavy)
                else:
                    if not (heavy < np.inf and free[(i - 4) >> 1] and free[2 + (i & 1)]):
                        continue
                    there = before + 0.5 * SQRT2 * (weight + heavy)
                if there >= field[v] - slack or there > limit:
                    continue
                field[v] = there
                bucket = max(now, int(there * inverse))  # below now by rounding only
                if n == count - 1 and bucket == now and count < 8:
                    u, so_far, came, going = v, there, i, True  # without the open list
                else:
                    code = int(np.int64(v)) * 16 + i
                    lists = push(heads, entries, costs, lists, bucket & mask, code, there)
                    waiting += 1
    return True


@njit(cache=True)
def _descend(weights: Floats32, field: Floats, initial: Floats, stride: int, last: int) -> Integers:
    """The cells (k, 2) up to ``last``, each the cheapest parent of the next."""
    back = [last]
    u = last
    while field[u] < initial[(u // stride - 1) * (stride - 2) + u % stride - 1]:
        best, parent = np.inf, -1
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                v = u + dr * stride + dc
                if v == u or field[v] == np.inf:
                    continue
                half = 0.5
                if dr != 0 and dc != 0:
                    if weights[u + dr * stride] + weights[u + dc] == np.inf:
                        continue
                    half = 0.5 * SQRT2
                through = field[v] + half * (np.float64(weights[u]) + np.float64(weights[v]))
                if through < best:
                    best, parent = through, v
        u = parent
        back.append(u)
    out = np.empty((len(back), 2), dtype=np.int64)
    for i in range(len(back)):
        out[i, 0] = back[len(back) - 1 - i] // stride - 1
        out[i, 1] = back[len(back) - 1 - i] % stride - 1
    return out
