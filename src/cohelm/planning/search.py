"""The cheapest way over a grid of weights: exact A*, compiled.

The grid is 8-connected. A step from cell u to its neighbour v costs length · (w_u + w_v) / 2 (as in
scikit-image's MCP_Geometric) and must not cut the corner of a blocked cell. The heuristic is the
octile distance times the least weight, which is admissible and consistent, so the path is optimal.

The open list is a ring of buckets, about half the least weight wide, each a stack. Within a bucket
the order is free: a cell that becomes cheaper after it was expanded is expanded again, and the
search ends when the buckets that could hold a cheaper way to the goal are empty. So width and
rounding cost time, never exactness.
"""

from __future__ import annotations

import math
from dataclasses import field
from typing import Any

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

BLOCKED = np.float32(np.inf)
"""The weight of a cell that must not be entered."""

_SQRT2 = math.sqrt(2.0)
_MAX_BUCKETS = 1 << 16
_FOUND, _NO_WAY, _OUT_OF_BUDGET = 0, 1, 2


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
        packed: Floats32 = empty_for_copies((cost.shape[0] + 2, cost.shape[1] + 2), np.float32)
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
    flat, stride = weights.packed.ravel(), weights.packed.shape[1]
    first = (start[0] + 1) * stride + start[1] + 1
    last = (goal[0] + 1) * stride + goal[1] + 1
    if not (np.isfinite(flat[first]) and np.isfinite(flat[last])):
        return None
    if first == last:
        return GridPath(cells=np.array([start]), cost=0.0, expansions=0)
    reached = np.zeros(flat.size)  # pages that the search never touches are never made
    budget = np.iinfo(np.int64).max if max_expansions is None else max_expansions
    outcome, expansions = _search(
        flat, reached, stride, first, last, weights.lightest, weights.heaviest, budget
    )
    if outcome == _OUT_OF_BUDGET:
        raise PlanningTimeout(f"no path within {max_expansions} expanded cells")
    if outcome == _NO_WAY:
        return None
    cells = _trace(flat, reached, stride, first, last)
    return GridPath(cells=cells, cost=path_cost(weights.packed, cells), expansions=expansions)


@njit(cache=True)
def pack_costs(cost: Bytes, table: Floats32, packed: Floats32, row: int, col: int) -> None:
    """Weigh a window's costs, which begins at (row, col) of the grid, in packed weights."""
    for r in range(cost.shape[0]):
        for c in range(cost.shape[1]):
            packed[row + r + 1, col + c + 1] = table[cost[r, c]]


@njit(cache=True)
def path_cost(weights: Floats32, cells: Integers) -> float:
    """Cost of a way (k, 2) over packed weights, in cells, summed in float64."""
    total = 0.0
    for i in range(cells.shape[0] - 1):
        r0, c0, r1, c1 = cells[i, 0], cells[i, 1], cells[i + 1, 0], cells[i + 1, 1]
        half = 0.5 * _SQRT2 if r0 != r1 and c0 != c1 else 0.5
        total += half * (np.float64(weights[r0 + 1, c0 + 1]) + np.float64(weights[r1 + 1, c1 + 1]))
    return total


@njit(cache=True)
def _search(  # noqa: PLR0912, PLR0915, PLR0917  # split up, it took twice as long
    weights: Floats32,
    reached: Floats,
    stride: int,
    start: int,
    goal: int,
    lightest: float,
    heaviest: float,
    budget: int,
) -> tuple[int, int]:
    """Fill ``reached`` from the start; (outcome, cells expanded).

    A cell's value is 0 where it was not reached, else the cost so far, negative once the cell was
    expanded at that cost. Indices are unsigned, which saves a test at each access.
    """
    heads, width = _buckets(lightest, heaviest)
    mask, inverse = heads.shape[0] - 1, 1.0 / width
    pool = np.empty((1 << 14, 2), dtype=np.int64)  # (cell, next entry of the same bucket)
    pool[0, 0], pool[0, 1] = start, -1
    heads[0] = 0
    spare, fresh, waiting = -1, 1, 1  # first recycled entry, first unused one, entries in use
    offset, rows, cols = _neighbours(stride)
    free = np.zeros(4, dtype=np.bool_)
    goal_row, goal_col = goal // stride, goal % stride
    base = lightest * _octile(start // stride - goal_row, start % stride - goal_col)
    reached[start] = 5e-324  # nothing, yet not "not reached"
    now, last, best, expansions = 0, 1 << 62, np.inf, 0
    while waiting > 0 and now <= last:
        entry = heads[now & mask]
        if entry < 0:
            now += 1
            continue
        u = np.uint64(pool[entry, 0])
        heads[now & mask] = pool[entry, 1]
        pool[entry, 1], spare = spare, entry
        waiting -= 1
        so_far = reached[u]
        if so_far < 0.0:
            continue
        reached[u] = -so_far
        expansions += 1
        if expansions > budget:
            return _OUT_OF_BUDGET, expansions
        row = np.int64(u // np.uint64(stride))
        col = np.int64(u) - row * stride
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
            known = abs(reached[v])
            if known != 0.0 and there >= known:
                continue
            f = there + lightest * _octile(row + rows[i] - goal_row, col + cols[i] - goal_col)
            if f >= best:
                continue
            reached[v] = there
            bucket = max(now, int((f - base) * inverse))  # below now by rounding only
            if v == np.uint64(goal):
                best, last = there, bucket
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
    return (_FOUND if reached[goal] != 0.0 else _NO_WAY), expansions


@njit(cache=True)
def _octile(rows: int, cols: int) -> float:
    """The length of the shortest 8-connected way over free cells."""
    r, c = abs(rows), abs(cols)
    return float(max(r, c) + (_SQRT2 - 1.0) * min(r, c))


@njit(cache=True)
def _buckets(lightest: float, heaviest: float) -> tuple[Integers, float]:
    """(an empty ring of buckets, width of a bucket).

    f grows by at most a step and what it adds to the heuristic, so a ring that spans that much
    holds every bucket in use.
    """
    span = _SQRT2 * (heaviest + lightest)
    width = max(0.5 * lightest, span / (_MAX_BUCKETS - 4))
    count = 4
    while count * width < span + 2.0 * width:
        count *= 2
    return np.full(count, -1, dtype=np.int64), width


@njit(cache=True)
def _neighbours(stride: int) -> tuple[Any, Integers, Integers]:
    """(index offset modulo 2⁶⁴, row step, column step) of the eight, straight ones first."""
    rows = np.array([-1, 1, 0, 0, -1, -1, 1, 1])
    cols = np.array([0, 0, -1, 1, -1, 1, -1, 1])
    return (rows * stride + cols).astype(np.uint64), rows, cols


@njit(cache=True)
def _doubled(pool: Integers) -> Integers:
    larger = np.empty((2 * pool.shape[0], pool.shape[1]), dtype=np.int64)
    larger[: pool.shape[0]] = pool
    return larger


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
                    half = 0.5 * _SQRT2
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
