"""The cheapest way over a grid of weights: exact A*, compiled.

The grid is 8-connected. A step from cell u to its neighbour v costs length · (w_u + w_v) / 2 (as in
scikit-image's MCP_Geometric) and must not cut the corner of a blocked cell. Three things make it
fast, none of which gives up exactness:

- The heuristic of :mod:`cohelm.planning.bounds` knows walls and weights as far as a grid of a
  quarter or an eighth the resolution can, and is a consistent lower bound.
- The open list is a ring of buckets, each a stack. A cell that becomes cheaper later is expanded
  again, and the search ends when no bucket is left that could hold a cheaper way.
- On even ground only the steps are taken that could belong to a cheapest way and to no equal one
  (:func:`cohelm.planning.buckets.successors`), one after another without the open list.

What a cell's cost would better by less than ``SLACK`` is left: ways of equal length add up to sums
that differ in the last digits. The cost returned is summed along the cells anew.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np
from numba import njit

from cohelm.arrays import (
    Annotated,
    Bytes,
    Floats,
    Floats32,
    Integers,
    Shape,
    empty_for_copies,
    value,
)
from cohelm.errors import PlanningTimeout
from cohelm.planning.bounds import bound_at, lower_bound, shift_for
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
from cohelm.planning.workspace import PAGE, clean, give_back, take

BLOCKED = np.float32(np.inf)
"""The weight of a cell that must not be entered."""

_NOTHING = 5e-324  # the cost so far at the start, which is not "not reached"
_WIDTH = 0.5  # of a bucket, in least weights
_FOUND, _NO_WAY, _OUT_OF_BUDGET, _OUT_OF_ROOM = 0, 1, 2, 3


@value
class GridPath:
    """An optimal way over a grid."""

    cells: Annotated[Integers, Shape("k 2")]
    """(row, column), start and goal included."""
    cost: float
    """In cells: multiply by the resolution for metres. Summed in float64 along the cells."""
    expansions: int
    """Cells expanded, counted as often as they were."""
    pins: Annotated[Integers, Shape("p")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Rising indices of cells that the line made of the way must go on passing within a cell of:
    the way was paid for to come there, and neither shortening nor smoothing may give that away."""


@value
class Weights:
    """What a step costs on each cell, packed for the search."""

    packed: Annotated[Floats32, Shape("rows cols")]
    """The grid with a blocked border one cell wide; > 0; ``BLOCKED`` where no way leads."""
    lightest: float
    """No passable cell weighs less; > 0. The nearer the truth, the faster the search."""
    heaviest: float
    """No passable cell weighs more."""

    @staticmethod
    def of_costs(cost: Bytes, table: Floats32) -> Weights:
        """Costs (rows, cols) weighed by a table (256,), whose blocked entries are infinite."""
        rows, cols = cost.shape
        packed: Floats32 = empty_for_copies((rows + 2, cols + 2), np.float32)
        packed[[0, -1], :] = BLOCKED
        packed[:, [0, -1]] = BLOCKED
        pack_costs(cost, table, packed, 0, 0)
        packed.flags.writeable = False
        passable = table[np.isfinite(table)]
        lightest = min(float(table[int(cost.min()) :].min()), float(passable.max()))
        return Weights(packed=packed, lightest=lightest, heaviest=float(passable.max()))

    @staticmethod
    def of(weights: Floats32) -> Weights:
        """Weights (rows, cols) as they are.

        Raises:
            ValueError: if one is not positive.
        """
        if not bool((weights > 0.0).all()):
            raise ValueError("weights must be positive")
        packed = np.pad(weights, 1, constant_values=BLOCKED)
        passable = weights[np.isfinite(weights)]
        low, high = (passable.min(), passable.max()) if passable.size else (1.0, 1.0)
        return Weights(packed=packed, lightest=float(low), heaviest=float(high))


def shortest_path(
    weights: Weights,
    start: tuple[int, int],
    goal: tuple[int, int],
    *,
    max_expansions: int | None = None,
) -> GridPath | None:
    """The cheapest 8-connected way from ``start`` to ``goal``, or None where there is none.

    Args:
        weights: of the grid's cells.
        start, goal: (row, column), on the grid.
        max_expansions: the budget, cells; None: as many as it takes.

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
    outcome, room, work = _OUT_OF_ROOM, flat.size // 32 + 1024, take(flat.size)
    while outcome == _OUT_OF_ROOM:
        room *= 4
        clean(work)
        outcome, expansions = _search(
            flat, work.reached, work.used, nodes, shift, stride, first, last, *bounds, budget, room
        )
    cells = _trace(flat, work.reached, stride, first, last) if outcome == _FOUND else None
    give_back(work)
    if outcome == _OUT_OF_BUDGET:
        raise PlanningTimeout(f"no path within {max_expansions} expanded cells")
    if cells is None:
        return None
    return GridPath(cells=cells, cost=path_cost(weights.packed, cells), expansions=expansions)


@njit(cache=True)
def pack_costs(cost: Bytes, table: Floats32, packed: Floats32, row: int, col: int) -> None:
    """Put the weights of a window's costs, by a table (256,), where it lies in packed weights.

    Args:
        cost: of the window.
        table: weights of costs.
        packed: (rows + 2, cols + 2), changed in place.
        row, col: of the grid, where the window begins.
    """
    for r in range(cost.shape[0]):
        for c in range(cost.shape[1]):
            packed[row + r + 1, col + c + 1] = table[cost[r, c]]


@njit(cache=True)
def path_cost(weights: Floats32, cells: Integers) -> float:
    """Cost of a way (k, 2) over packed weights, in cells, summed in float64."""
    total = 0.0
    for i in range(cells.shape[0] - 1):
        r0, c0, r1, c1 = cells[i, 0], cells[i, 1], cells[i + 1, 0], cells[i + 1, 1]
        half = 0.5 * SQRT2 if r0 != r1 and c0 != c1 else 0.5
        total += half * (np.float64(weights[r0 + 1, c0 + 1]) + np.float64(weights[r1 + 1, c1 + 1]))
    return total


@njit(cache=True)
def _search(  # noqa: PLR0912, PLR0913, PLR0915, PLR0917  # one hot loop
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
    room: int,
) -> tuple[int, int]:
    """Fill ``reached`` from the start; (outcome, cells expanded).

    A cell's value is 0 where it was not reached, else the cost so far. An entry of the open list is
    16 · cell + the step that led there; it is stale once the cell has another value.
    """
    values, width = nodes.reshape(-1), nodes.shape[1]
    heads, step = ring(_WIDTH * lightest, 2.0 * SQRT2 * heaviest)
    entries, costs, lists = np.empty((room, 2), dtype=np.int64), np.empty(room), (-1, 0)
    mask, inverse, slack = heads.shape[0] - 1, 1.0 / step, SLACK * lightest
    offset, rows, cols = neighbours(stride)
    ahead, counts = successors()
    free, wide, page = np.zeros(4, dtype=np.bool_), np.uint64(stride), np.uint64(PAGE)
    base = bound_at(values, width, start // stride, start % stride, shift)
    reached[start], used[start >> PAGE] = _NOTHING, 1
    lists = push(heads, entries, costs, lists, 0, 16 * start + ANY, _NOTHING)
    now, last, best, waiting, expansions = 0, 1 << 62, np.inf, 1, 0
    while waiting > 0 and now <= last:
        entry = heads[now & mask]
        if entry < 0:
            now += 1
            continue
        lists = drop(heads, entries, lists, now & mask)
        waiting -= 1
        u = np.uint64(entries[entry, 0] >> 4)
        so_far, came = costs[entry], entries[entry, 0] & 15
        going = reached[u] == so_far
        while going:
            going = False
            expansions += 1
            if expansions > budget:
                return _OUT_OF_BUDGET, expansions
            if lists[1] + 8 > room:
                return _OUT_OF_ROOM, expansions
            row = np.int64(u // wide)
            col = np.int64(u) - row * stride
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
                known = reached[v]
                if known != 0.0 and there >= known - slack:
                    continue
                f = there + bound_at(values, width, row + rows[i], col + cols[i], shift)
                if f >= best:
                    continue
                reached[v] = there
                used[v >> page] = 1
                bucket = max(now, int((f - base) * inverse))  # below now by rounding only
                if v == np.uint64(goal):
                    best, last = f, bucket
                if n == count - 1 and bucket == now and count < 8:
                    u, so_far, came, going = v, there, i, True  # without the open list
                else:
                    code = int(np.int64(v)) * 16 + i
                    lists = push(heads, entries, costs, lists, bucket & mask, code, there)
                    waiting += 1
    return (_FOUND if reached[goal] != 0.0 else _NO_WAY), expansions


@njit(cache=True)
def _trace(weights: Floats32, reached: Floats, stride: int, start: int, goal: int) -> Integers:
    """The cells (k, 2) from start to goal, each the cheapest parent of the next."""
    back = [goal]
    u = goal
    while u != start:
        best, parent = np.inf, -1
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                v = u + dr * stride + dc
                if v == u or reached[v] == 0.0:
                    continue
                if dr != 0 and dc != 0:
                    beside = weights[u + dr * stride] + weights[u + dc]
                    if beside == np.inf:
                        continue
                    half = 0.5 * SQRT2
                else:
                    half = 0.5
                through = abs(reached[v]) + half * (np.float64(weights[u]) + np.float64(weights[v]))
                if through < best:
                    best, parent = through, v
        u = parent
        back.append(u)
    out = np.empty((len(back), 2), dtype=np.int64)
    for i in range(len(back)):
        out[i, 0] = back[len(back) - 1 - i] // stride - 1
        out[i, 1] = back[len(back) - 1 - i] % stride - 1
    return out
