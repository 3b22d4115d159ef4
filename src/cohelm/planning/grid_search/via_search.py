"""A* over layers of a grid with via points, compiled: the kernel of ``via_points``.

The steps within a layer, and the steps that are left out, are those of
:mod:`cohelm.planning.grid_search.grid_steps`. Passing a via point leads to another layer at the
same cell and costs the price of the distance there; the goal is its cell in the last layer.

The heuristic extends :mod:`cohelm.planning.grid_search.lower_bound`. A layer's bound decreases
along no step by more than the cost of the step, and passing a point at a cell saves no more than
its price there. From the last layer to the first, the nodes have the greatest values that keep the
first condition within the layer, and at every node v the second one in the form

    h_layer(v) ≤ h_next(v) + price · max(|v − point| − e, 0).

On a triangle of nodes, the linear function with the values of the last factor must not exceed the
distance from the point. It does not for two reasons, with R the radius of the circumscribed circle.
For e = 2 R, which is the distance between nodes, no value at a node exceeds the distance from
anywhere on the triangle. And if the whole triangle is at least r from the point, the linear
function of the distances exceeds the distance by at most R² / 2r. So h_layer does not exceed h_next
and the price on the triangles of h_next. On the two other triangles of a square, h_layer could only
be lower if it were linear on those instead.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import NONE, ZERO
from cohelm.arrays import Floats, Floats32, Integers
from cohelm.kernels import CACHED, callee
from cohelm.planning.grid_search.bucket_queue import (
    SLACK,
    double_rows,
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
from cohelm.planning.grid_search.lower_bound import (
    COARSE_SHIFT,
    bound_at,
    cap_nodes,
    empty_nodes,
    propagate,
    seed_goal,
)

OUT_OF_BUDGET = -1
"""Number of expansions that is returned if the budget is used up."""

_AT_START = 5e-324  # cost so far at the start; 0 means "not reached"
_MAX_BUCKETS = 1 << 22
_SIDE = 1 << COARSE_SHIFT
_ACROSS = _SIDE * math.sqrt(2.0)  # 2 R


class ViaGraph(NamedTuple):
    """Graph of the layers, for kernels."""

    edges_from: Integers
    """First row in ``edges`` of each layer, (layers + 1,)."""
    edges: Integers
    """(next layer, point passed), (e, 2)."""
    points: Floats
    """(row, column, price, distance to the grid, for which every path pays equally), (p, 4)."""


@njit(**CACHED)
def search_layers(  # noqa: PLR0912, PLR0915  # one hot loop over plain arrays
    weights: Floats32,
    reached: Floats,
    nodes: Floats,
    stride: int,
    start: int,
    goal: int,
    lightest: float,
    bound: float,
    graph: ViaGraph,
    budget: int,
) -> tuple[Integers, int]:
    """(states from start to goal, expansions or ``OUT_OF_BUDGET``).

    A state is layer · size + cell. ``reached`` (states,) must be all 0; then a state's value is 0
    if it was not reached, else the cost so far. An entry of the open list is 16 · state + the step
    that led there. f never exceeds ``bound``, which includes the value of ``nodes`` at the goal, so
    the buckets are a plain array.
    """
    edges_from, edges, points = graph
    size, width = weights.shape[0], nodes.shape[2]
    values = nodes.reshape(nodes.shape[0], -1)
    target = (edges_from.shape[0] - 2) * size + goal
    # The open list, with the start in the first bucket; its key is f, the cost over this state.
    base = bound_at(values[0], width, start // stride, start % stride, COARSE_SHIFT)
    step = max(0.5 * lightest, (bound - base) / (_MAX_BUCKETS - 4))
    inverse, slack = 1.0 / step, SLACK * lightest
    heads = np.full(int(max(bound - base, 0.0) * inverse) + 3, -1, dtype=np.int64)
    capacity = 1 << 14
    entries, costs = np.empty((capacity, 2), dtype=np.int64), np.empty(capacity)
    lists = (NONE, ZERO)
    offset, rows, cols = neighbours(stride)
    ahead, counts = successors()
    free, wide = np.zeros(4, dtype=np.bool_), np.uint64(stride)
    reached[start] = _AT_START
    lists = push(heads, entries, costs, lists, ZERO, 16 * start + ANY_STEP, _AT_START)
    now, last, best, waiting, expansions = 0, 1 << 62, bound, 1, 0
    while waiting > 0 and now <= last:
        # Take the newest entry of the lowest bucket, unless it is stale.
        entry = heads[now]
        if entry < 0:
            now += 1
            continue
        lists = pop(heads, entries, lists, now)
        waiting -= 1
        state = entries[entry, 0] >> 4
        so_far, came = costs[entry], entries[entry, 0] & 15
        layer = state // size
        u, shift = np.uint64(state - layer * size), np.uint64(layer * size)
        left, first = values[layer], edges_from[layer]
        # Expand the state, then go on to the last neighbour while that is in the lowest bucket.
        going = reached[u + shift] == so_far
        while going:
            going = False
            expansions += 1
            if expansions > budget:
                return np.empty(0, dtype=np.int64), OUT_OF_BUDGET
            while lists[1] + 8 + edges_from[layer + 1] - first > entries.shape[0]:
                entries, costs = double_rows(entries), double_rows(costs)
            row = np.int64(u // wide)
            col = np.int64(u) - row * stride
            # Pass each via point that is next in its chain here, which leads to another layer.
            for k in range(first, edges_from[layer + 1]):
                there = so_far + _price(points, int(edges[k, 1]), int(row) - 1, int(col) - 1)
                then = edges[k, 0]
                v = u + np.uint64(then * size)
                known = reached[v]
                if known != 0.0 and there >= known - slack:
                    continue
                f = there + bound_at(values[then], width, int(row), int(col), COARSE_SHIFT)
                if f >= best:
                    continue
                reached[v] = there
                bucket = max(now, int((f - base) * inverse))  # below now only by rounding
                if v == np.uint64(target):
                    best, last = f, bucket
                code = int(np.int64(v)) * 16 + ANY_STEP
                lists = push(heads, entries, costs, lists, bucket, code, there)
                waiting += 1
            # Steps within the layer: all of them beside other weights, only the worthwhile ones
            # among uniform weights.
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
                known = reached[v + shift]
                if known != 0.0 and there >= known - slack:
                    continue
                f = there + bound_at(left, width, row + rows[i], col + cols[i], COARSE_SHIFT)
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
    return _trace(weights, reached, stride, start, target, graph), expansions


@callee()
def _price(points: Floats, point: int, row: int, col: int) -> float:
    """Price of passing a point at a cell, without the part that is equal for all cells."""
    far = math.hypot(points[point, 0] - row, points[point, 1] - col)
    return float(points[point, 2] * max(far - points[point, 3], 0.0))


@callee()
def _trace(
    weights: Floats32, reached: Floats, stride: int, start: int, target: int, graph: ViaGraph
) -> Integers:
    """Trace the states from start to target; each is the cheapest parent of the next."""
    edges_from, edges, points = graph
    size = weights.shape[0]
    back = [target]
    state = target
    while state != start:
        layer, u = state // size, state % size
        first = layer * size
        best, parent = cheapest_parent(weights, reached[first : first + size], stride, u)
        parent += first
        # A via point may have been passed here, from a layer before.
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


@njit(**CACHED)
def layer_bounds(
    weights: Floats32,
    graph: ViaGraph,
    goal: tuple[int, int],
    lightest: float,
    heaviest: float,
    most: float,
) -> Floats:
    """Values at the nodes of each layer, to be read with ``lower_bound.bound_at``.

    All bounds are too great by the same number, namely the last layer's value at the goal.

    Args:
        weights: (rows, cols), with a blocked border.
        graph: the layers.
        goal: (row, column) in ``weights``.
        lightest, heaviest: lower and upper bound of the passable weights.
        most: highest value that must be correct.
    """
    edges_from, edges, points = graph
    shift = ZERO + COARSE_SHIFT
    squares, blanks = empty_nodes(weights, shift)
    layers = edges_from.shape[0] - 1
    nodes = np.full((layers, *blanks.shape), np.inf)
    capacity = blanks.size + 64
    for layer in range(layers - 1, -1, -1):
        reach = -np.inf
        while reach == -np.inf:
            here = nodes[layer]
            here[:] = np.inf
            if layer == layers - 1:
                seed_goal(weights, squares, here, goal, shift)
            for k in range(edges_from[layer], edges_from[layer + 1]):
                _credit(nodes[edges[k, 0]], points[edges[k, 1]], here)
            reach = propagate(
                weights, squares, here, NONE, lightest, heaviest, most, capacity, shift
            )
            if reach == -np.inf:
                capacity *= 4
        cap_nodes(here, reach)
    return nodes


@callee()
def _credit(then: Floats, point: Floats, here: Floats) -> None:
    """Lower a layer's nodes to those of the next layer plus the price of a point."""
    row, col, price, beyond = point[0], point[1], point[2], point[3]
    for i in range(here.shape[0]):
        for j in range(here.shape[1] - 1):  # the last column holds no nodes
            far = math.hypot(i * _SIDE - 1 - row, j * _SIDE - 1 - col)
            error = _ACROSS
            if beyond == 0.0 and far > 2.0 * _ACROSS:
                error = 0.125 * _ACROSS * _ACROSS / (far - _ACROSS)
            paid = price * max(far - beyond - error, 0.0)
            here[i, j] = min(here[i, j], then[i, j] + paid)
