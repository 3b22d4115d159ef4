"""What it costs to reach every cell of a grid: exact Dijkstra, compiled.

The steps are those of :mod:`cohelm.planning.search`: 8-connected, length · (w_u + w_v) / 2, and no
corner of a blocked cell cut. The open list is a ring of buckets that are no wider than the cheapest step,
so a cell is final when its bucket is reached and is expanded once. Rounding may break that by a
hair; a cell that becomes cheaper afterwards is then expanded again, so the values are exact always.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.planning.search import Weights, _buckets, _doubled, _neighbours

_SQRT2 = 2.0**0.5
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
    out = np.full(weights.packed.shape, np.inf)
    flat = weights.packed.ravel()
    cols = weights.packed.shape[1]
    _flood(flat, out.ravel(), cols, seeds, costs, weights.lightest, weights.heaviest, limit)
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
def _flood(  # noqa: PLR0912, PLR0915, PLR0917  # one hot loop; see search
    weights: Floats32,
    field: Floats,
    stride: int,
    seeds: Integers,
    costs: Floats,
    lightest: float,
    heaviest: float,
    limit: float,
) -> None:
    """Fill ``field``, infinite before, from the seeds; they join when their bucket comes.

    A cell's value is negative once it was expanded at that cost.
    """
    heads, width = _buckets(lightest, heaviest)
    mask, inverse = heads.shape[0] - 1, 1.0 / width
    pool = np.empty((1 << 14, 2), dtype=np.int64)  # (cell, next entry of the same bucket)
    spare, fresh, waiting = -1, 0, 0
    offset, _, _ = _neighbours(stride)
    free = np.zeros(4, dtype=np.bool_)
    joined, now = 0, 0
    while True:
        if waiting == 0:
            if joined == seeds.shape[0]:
                break
            now = max(now, int(costs[joined] * inverse))
        while joined < seeds.shape[0] and int(costs[joined] * inverse) <= now:
            v, there = np.uint64(seeds[joined]), costs[joined]
            joined += 1
            if not (weights[v] < np.inf and there < abs(field[v])):
                continue
            field[v] = there
            if spare >= 0:
                entry, spare = spare, pool[spare, 1]
            else:
                entry = fresh
                fresh += 1
                if entry == pool.shape[0]:
                    pool = _doubled(pool)
            pool[entry, 0], pool[entry, 1] = np.int64(v), heads[now & mask]
            heads[now & mask] = entry
            waiting += 1
        entry = heads[now & mask]
        if entry < 0:
            now += 1
            continue
        u = np.uint64(pool[entry, 0])
        heads[now & mask] = pool[entry, 1]
        pool[entry, 1], spare = spare, entry
        waiting -= 1
        so_far = field[u]
        if np.signbit(so_far):
            continue
        field[u] = -so_far
        weight = np.float64(weights[u])
        for i in range(8):
            v = u + offset[i]
            heavy = np.float64(weights[v])
            if i < 4:
                free[i] = heavy < np.inf
                if not free[i]:
                    continue
                there = so_far + 0.5 * (weight + heavy)
            else:
                if not (heavy < np.inf and free[(i - 4) >> 1] and free[2 + (i & 1)]):
                    continue
                there = so_far + 0.5 * _SQRT2 * (weight + heavy)
            if there >= abs(field[v]) or there > limit:
                continue
            field[v] = there
            bucket = max(now, int(there * inverse))  # below now by rounding only
            if spare >= 0:
                entry, spare = spare, pool[spare, 1]
            else:
                entry = fresh
                fresh += 1
                if entry == pool.shape[0]:
                    pool = _doubled(pool)
            pool[entry, 0], pool[entry, 1] = np.int64(v), heads[bucket & mask]
            heads[bucket & mask] = entry
            waiting += 1
    for i in range(field.shape[0]):
        field[i] = abs(field[i])


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
                    half = 0.5 * _SQRT2
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
