"""A* over layers of a grid: the kernel of :mod:`cohelm.planning.via`.

The steps within a layer are those of :mod:`cohelm.planning.search`. Crediting a point leads to
another layer at the same cell and costs its price there; the goal is its cell in the last layer.
The heuristic is

    least weight · (share · shortest tour left + (1 − share) · octile distance to the goal)

with the tours and the share of :mod:`cohelm.planning.via_layers`. It is consistent.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.planning.buckets import SLACK, doubled, neighbours
from cohelm.planning.via_layers import octile

OUT_OF_BUDGET = -1

_SQRT2 = math.sqrt(2.0)
_MAX_BUCKETS = 1 << 22


@njit(cache=True)
def search(  # noqa: PLR0912, PLR0913, PLR0915, PLR0917  # one hot loop; see search
    weights: Floats32,
    reached: Floats,
    stride: int,
    start: int,
    goal: int,
    lightest: float,
    bound: float,
    edges_from: Integers,
    edges: Integers,
    points: Floats,
    tours_from: Integers,
    tours: Floats,
    share: float,
    budget: int,
) -> tuple[Integers, int]:
    """(the states from start to goal, states expanded or ``OUT_OF_BUDGET``).

    A state is layer · size + cell. ``reached`` (states,) is all 0 before; as in the plain search a
    state's value is 0 where it was not reached, else the cost so far, negative once it was expanded
    at that cost. f is at most ``bound`` all along, so the buckets are a plain array.
    """
    size = weights.shape[0]
    target = (edges_from.shape[0] - 2) * size + goal
    goal_row, goal_col = goal // stride - 1, goal % stride - 1
    base = _to_go(
        start // stride - 1, start % stride - 1, 0, tours_from, tours, share, goal_row, goal_col
    )
    base *= lightest
    width = max(0.5 * lightest, (bound - base) / (_MAX_BUCKETS - 4))
    inverse, slack = 1.0 / width, SLACK * lightest
    heads = np.full(int(max(bound - base, 0.0) * inverse) + 3, -1, dtype=np.int64)
    pool = np.empty((1 << 14, 2), dtype=np.int64)  # (state, next entry of the same bucket)
    pool[0, 0], pool[0, 1] = start, -1
    heads[0] = 0
    spare, fresh, waiting = -1, 1, 1  # first recycled entry, first unused one, entries in use
    offset, rows, cols = neighbours(stride)
    free = np.zeros(4, dtype=np.bool_)
    reached[start] = 5e-324  # nothing, yet not "not reached"
    now, last, best, expansions = 0, 1 << 62, bound, 0
    while waiting > 0 and now <= last:
        entry = heads[now]
        if entry < 0:
            now += 1
            continue
        state = pool[entry, 0]
        heads[now] = pool[entry, 1]
        pool[entry, 1], spare = spare, entry
        waiting -= 1
        so_far = reached[np.uint64(state)]
        if so_far < 0.0:
            continue
        reached[np.uint64(state)] = -so_far
        expansions += 1
        if expansions > budget:
            return np.empty(0, dtype=np.int64), OUT_OF_BUDGET
        layer = state // size
        u = np.uint64(state - layer * size)
        row = (state - layer * size) // stride - 1
        col = (state - layer * size) % stride - 1
        weight = np.float64(weights[u])
        shift = np.uint64(layer * size)
        first = edges_from[layer]
        direct = lightest * octile(row - goal_row, col - goal_col)
        for i in range(8 + edges_from[layer + 1] - first):
            to, r, c = layer, row, col
            if i < 8:
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
                v += shift
                r, c = row + rows[i], col + cols[i]
            else:
                to = edges[first + i - 8, 0]
                there = so_far + _price(points, edges[first + i - 8, 1], row, col)
                if there + direct >= best:
                    continue
                v = u + np.uint64(to * size)
            known = abs(reached[v])
            if known != 0.0 and there >= known - slack:
                continue
            left = _to_go(r, c, to, tours_from, tours, share, goal_row, goal_col)
            f = there + lightest * left
            if f >= best:
                continue
            reached[v] = there
            bucket = max(now, int((f - base) * inverse))  # below now by rounding only
            if v == np.uint64(target):
                best, last = there, bucket
            if spare >= 0:
                entry, spare = spare, pool[spare, 1]
            else:
                entry = fresh
                fresh += 1
                if entry == pool.shape[0]:
                    pool = doubled(pool)
            pool[entry, 0], pool[entry, 1] = np.int64(v), heads[bucket]
            heads[bucket] = entry
            waiting += 1
    return _trace(weights, reached, stride, start, target, edges_from, edges, points), expansions


@njit(cache=True)
def _price(points: Floats, point: int, row: int, col: int) -> float:
    """Of crediting a point at a cell, without what every cell pays."""
    far = math.hypot(points[point, 0] - row, points[point, 1] - col)
    return float(points[point, 2] * max(far - points[point, 3], 0.0))


@njit(cache=True)
def _to_go(  # noqa: PLR0917  # a kernel takes plain arguments
    row: int,
    col: int,
    layer: int,
    tours_from: Integers,
    tours: Floats,
    share: float,
    goal_row: int,
    goal_col: int,
) -> float:
    """No way from a cell of a layer to the goal is shorter, prices included, at weight 1."""
    shortest = np.inf
    for i in range(tours_from[layer], tours_from[layer + 1]):
        shortest = min(shortest, octile(row - tours[i, 0], col - tours[i, 1]) + tours[i, 2])
    return share * shortest + (1.0 - share) * octile(row - goal_row, col - goal_col)


@njit(cache=True)
def _trace(  # noqa: PLR0917  # a kernel takes plain arguments
    weights: Floats32,
    reached: Floats,
    stride: int,
    start: int,
    target: int,
    edges_from: Integers,
    edges: Integers,
    points: Floats,
) -> Integers:
    """The states from start to target, each the cheapest parent of the next."""
    size = weights.shape[0]
    back = [target]
    state = target
    while state != start:
        layer, u = state // size, state % size
        best, parent = np.inf, -1
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                v = u + dr * stride + dc
                if v == u or reached[layer * size + v] == 0.0:
                    continue
                half = 0.5
                if dr != 0 and dc != 0:
                    if weights[u + dr * stride] + weights[u + dc] == np.inf:
                        continue
                    half = 0.5 * _SQRT2
                step = half * (np.float64(weights[u]) + np.float64(weights[v]))
                if abs(reached[layer * size + v]) + step < best:
                    best, parent = abs(reached[layer * size + v]) + step, layer * size + v
        for other in range(layer):
            for i in range(edges_from[other], edges_from[other + 1]):
                v = other * size + u
                if edges[i, 0] != layer or reached[v] == 0.0:
                    continue
                price = _price(points, edges[i, 1], u // stride - 1, u % stride - 1)
                if abs(reached[v]) + price < best:
                    best, parent = abs(reached[v]) + price, v
        state = parent
        back.append(state)
    return np.array(back[::-1])
