"""A* over layers of a grid: the kernel of :mod:`cohelm.planning.via`.

The steps within a layer are those of :mod:`cohelm.planning.search`, and so is what is left out of
them. Crediting a point leads to another layer at the same cell and costs its price there; the goal
is its cell in the last layer. The heuristic is that of :mod:`cohelm.planning.via_bounds`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32, Integers
from cohelm.planning.bounds import COARSE, bound_at
from cohelm.planning.buckets import (
    ANY,
    SLACK,
    SQRT2,
    doubled,
    drop,
    is_even,
    neighbours,
    push,
    successors,
)

OUT_OF_BUDGET = -1

_NOTHING = 5e-324  # the cost so far at the start, which is not "not reached"
_MAX_BUCKETS = 1 << 22


@njit(cache=True)
def search(  # noqa: PLR0912, PLR0913, PLR0915, PLR0917  # one hot loop; see search
    weights: Floats32,
    reached: Floats,
    nodes: Floats,
    stride: int,
    start: int,
    goal: int,
    lightest: float,
    bound: float,
    edges_from: Integers,
    edges: Integers,
    points: Floats,
    budget: int,
) -> tuple[Integers, int]:
    """(the states from start to goal, states expanded or ``OUT_OF_BUDGET``).

    A state is layer · size + cell. ``reached`` (states,) is all 0 before; as in the plain search a
    state's value is 0 where it was not reached, else the cost so far; an entry of the open list is
    16 · state + the step that led there. f is at most ``bound`` all along, ``nodes`` at the goal
    included, so the buckets are a plain array.
    """
    size, width = weights.shape[0], nodes.shape[2]
    values = nodes.reshape(nodes.shape[0], -1)
    target = (edges_from.shape[0] - 2) * size + goal
    base = bound_at(values[0], width, start // stride, start % stride, COARSE)
    step = max(0.5 * lightest, (bound - base) / (_MAX_BUCKETS - 4))
    inverse, slack = 1.0 / step, SLACK * lightest
    heads = np.full(int(max(bound - base, 0.0) * inverse) + 3, -1, dtype=np.int64)
    room = 1 << 14
    entries, costs, lists = np.empty((room, 2), dtype=np.int64), np.empty(room), (-1, 0)
    offset, rows, cols = neighbours(stride)
    ahead, counts = successors()
    free, wide = np.zeros(4, dtype=np.bool_), np.uint64(stride)
    reached[start] = _NOTHING
    lists = push(heads, entries, costs, lists, 0, 16 * start + ANY, _NOTHING)
    now, last, best, waiting, expansions = 0, 1 << 62, bound, 1, 0
    while waiting > 0 and now <= last:
        entry = heads[now]
        if entry < 0:
            now += 1
            continue
        lists = drop(heads, entries, lists, now)
        waiting -= 1
        state = entries[entry, 0] >> 4
        so_far, came = costs[entry], entries[entry, 0] & 15
        layer = state // size
        u, shift = np.uint64(state - layer * size), np.uint64(layer * size)
        left, first = values[layer], edges_from[layer]
        going = reached[u + shift] == so_far
        while going:
            going = False
            expansions += 1
            if expansions > budget:
                return np.empty(0, dtype=np.int64), OUT_OF_BUDGET
            while lists[1] + 8 + edges_from[layer + 1] - first > entries.shape[0]:
                entries, costs = doubled(entries), doubled(costs)
            row = np.int64(u // wide)
            col = np.int64(u) - row * stride
            for k in range(first, edges_from[layer + 1]):
                there = so_far + _price(points, int(edges[k, 1]), int(row) - 1, int(col) - 1)
                then = edges[k, 0]
                v = u + np.uint64(then * size)
                known = reached[v]
                if known != 0.0 and there >= known - slack:
                    continue
                f = there + bound_at(values[then], width, int(row), int(col), COARSE)
                if f >= best:
                    continue
                reached[v] = there
                bucket = max(now, int((f - base) * inverse))  # below now by rounding only
                if v == np.uint64(target):
                    best, last = f, bucket
                code = int(np.int64(v)) * 16 + ANY
                lists = push(heads, entries, costs, lists, bucket, code, there)
                waiting += 1
            weight = np.float64(weights[u])
            if came != ANY and not is_even(weights, u, wide):
                came = ANY
            count, here, before = counts[came], u, so_far
            for n in range(count):
                i = n if came == ANY else ahead[came, n]
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
                known = reached[v + shift]
                if known != 0.0 and there >= known - slack:
                    continue
                f = there + bound_at(left, width, row + rows[i], col + cols[i], COARSE)
                if f >= best:
                    continue
                reached[v + shift] = there
                bucket = max(now, int((f - base) * inverse))
                if v + shift == np.uint64(target):
                    best, last = f, bucket
                if n == count - 1 and bucket == now and count < 8:
                    u, so_far, came, going = v, there, i, True  # without the open list
                else:
                    code = int(np.int64(v + shift)) * 16 + i
                    lists = push(heads, entries, costs, lists, bucket, code, there)
                    waiting += 1
    return _trace(weights, reached, stride, start, target, edges_from, edges, points), expansions


@njit(cache=True)
def _price(points: Floats, point: int, row: int, col: int) -> float:
    """Of crediting a point at a cell, without what every cell pays."""
    far = math.hypot(points[point, 0] - row, points[point, 1] - col)
    return float(points[point, 2] * max(far - points[point, 3], 0.0))


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
                    half = 0.5 * SQRT2
                step = half * (np.float64(weights[u]) + np.float64(weights[v]))
                if reached[layer * size + v] + step < best:
                    best, parent = reached[layer * size + v] + step, layer * size + v
        for other in range(layer):
            for i in range(edges_from[other], edges_from[other + 1]):
                v = other * size + u
                if edges[i, 0] != layer or reached[v] == 0.0:
                    continue
                price = _price(points, edges[i, 1], u // stride - 1, u % stride - 1)
                if reached[v] + price < best:
                    best, parent = reached[v] + price, v
        state = parent
        back.append(state)
    return np.array(back[::-1])
