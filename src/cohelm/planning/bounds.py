"""A lower bound of the cost from every cell to the goal, from a grid a fourth or eighth as fine.

The bound is a function h on the map, made of values at every fourth or eighth cell both ways. In a
square between four such nodes, h is linear on two triangles: the square is cut along the diagonal
whose ends sum to less. A function that falls along no step by more than the step costs, and is zero
at the goal, is a consistent lower bound. With w the least weight in the square, its border
included, and a the side of the square, that needs in each triangle a gradient (p, q) with

    |p| ≤ w,  |q| ≤ w,  |p + q| ≤ √2 w,  |p − q| ≤ √2 w.

For the values x, m, y, z of the nodes about a square, x and y beside m and z across, that is

    x ≤ m + w a,      z ≤ m + √2 w a,      2 x ≤ m + z + √2 w a,

each for every corner in the place of x or m. The third is for the cut that ends in m and z; what
the same cut needs of the two others, m + z ≤ 2 x + √2 w a, follows where m + z ≤ x + y, which is
how the cut is chosen. All three only say that a node is no dearer than something that grows with
others and is dearer than they are, so the greatest solution is found as shortest paths are.
On an empty floor h is the octile distance; and capping h keeps it a bound, so nodes much farther
than the start are left out. Rounding aside, the search that uses it is therefore exact.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.planning.buckets import SQRT2, drop, octile, push, ring

COARSE = 3
"""The shift of a cell's row and column to its square's: squares of eight cells by the side."""

_FINE, _FINE_CELLS = 2, 1 << 21
_TILE = 7  # shift to the tiles whose squares' least weights are found at once
_UNKNOWN = np.float32(-1.0)
_MARGIN = 1.02  # beyond the start's own bound, where the nodes end


@njit(cache=True)
def lower_bound(
    weights: Floats32,
    start: tuple[int, int],
    goal: tuple[int, int],
    lightest: float,
    heaviest: float,
    shift: int,
) -> Floats:
    """Values at the nodes, inf where no way leads, to be read by :func:`bound_at`.

    The bound is the same number too great everywhere, namely its value at the goal.

    Args:
        weights: (rows, cols), with a blocked border.
        start, goal: (row, column) in ``weights``.
        lightest, heaviest: what no passable weight is less or more than.
        shift: of a cell's row and column to its square's.
    """
    squares, nodes = blank(weights, shift)
    near = (start[0] >> shift) * nodes.shape[1] + (start[1] >> shift)
    room, reach = nodes.size + 64, -np.inf
    while reach == -np.inf:
        nodes[:] = np.inf
        seed(weights, squares, nodes, goal, shift)
        reach = settle(weights, squares, nodes, near, lightest, heaviest, np.inf, room, shift)
        room *= 4
    cap(nodes, reach)
    return nodes


@njit(cache=True)
def blank(weights: Floats32, shift: int) -> tuple[Floats32, Floats]:
    """(squares whose least weights are not known yet, nodes at infinity) of a grid.

    Node (i, j) has index k = i · width + j, and the squares about it have k and, with the border,
    k + 1, k + width and k + width + 1.
    """
    rows, cols = weights.shape
    side = 1 << shift
    down, across = (rows + side - 2) >> shift, (cols + side - 2) >> shift  # squares
    squares = np.full((down + 2, across + 2), np.inf, dtype=np.float32)
    squares[1:-1, 1:-1] = _UNKNOWN
    return squares, np.full((down + 1, across + 2), np.inf)


@njit(cache=True)
def seed(
    weights: Floats32, squares: Floats32, nodes: Floats, goal: tuple[int, int], shift: int
) -> None:
    """Set the nodes about the goal."""
    row, col = goal[0] >> shift, goal[1] >> shift
    _pool(weights, squares, row, col, shift)
    for i in range(row, row + 2):
        for j in range(col, col + 2):
            away = octile((i << shift) - goal[0], (j << shift) - goal[1])
            nodes[i, j] = np.float64(squares[row + 1, col + 1]) * away


@njit(cache=True)
def cap(nodes: Floats, most: float) -> None:
    """Let no node be dearer than that."""
    for i in range(nodes.shape[0]):
        for j in range(nodes.shape[1]):
            nodes[i, j] = min(nodes[i, j], most)


@njit(cache=True)
def settle(  # noqa: PLR0912, PLR0913, PLR0917  # one hot loop; a record of arrays costs time in it
    weights: Floats32,
    squares: Floats32,
    nodes: Floats,
    near: int,
    lightest: float,
    heaviest: float,
    most: float,
    room: int,
    shift: int,
) -> float:
    """Lower ``nodes``, some of them finite, to the greatest solution that is no greater.

    Args:
        weights, squares: of the grid; the squares' least weights are found as they are needed.
        nodes: changed in place.
        near: the first of four nodes about a square, not far beyond which to end; −1: none.
        lightest, heaviest: what no passable weight is less or more than.
        most: where to end at the latest.
        room: of the open list.
        shift: of a cell's row and column to its square's.

    Returns:
        How far the nodes are right: what is greater has to be capped at that. −inf where there was
        too little room.
    """
    side, width = float(1 << shift), nodes.shape[1]
    values, least = nodes.reshape(-1), squares.reshape(-1)
    low, high, waiting = np.inf, -np.inf, 0
    for node in range(values.shape[0]):
        if values[node] <= most and values[node] < np.inf:
            low, high, waiting = min(low, values[node]), max(high, values[node]), waiting + 1
    if waiting == 0:
        return most
    if waiting + 12 > room:
        return -np.inf
    heads, step = ring(0.5 * lightest * side, high - low + SQRT2 * heaviest * side)
    entries, costs, lists = np.empty((room, 2), dtype=np.int64), np.empty(room), (-1, 0)
    mask, inverse, slack = heads.shape[0] - 1, 1.0 / step, 1e-10 * lightest
    for node in range(values.shape[0]):
        value = values[node]
        if value <= most and value < np.inf:
            slot = int((value - low) * inverse) & mask
            lists = push(heads, entries, costs, lists, slot, node, value)
    now, last = 0, 1 << 62
    if most < np.inf:
        last = int((most - low) * inverse)
    while waiting > 0 and now <= last:
        if lists[1] + 12 > room:
            return -np.inf
        entry = heads[now & mask]
        if entry < 0:
            now += 1
            continue
        lists = drop(heads, entries, lists, now & mask)
        waiting -= 1
        node, value = entries[entry, 0], costs[entry]
        if values[node] != value:
            continue
        if near >= 0 and node - near in (0, 1, width, width + 1):
            last = min(last, int((_MARGIN * value + side * lightest - low) * inverse) + 1)
            near = -1
        for q in range(4):
            down, right = q >> 1, q & 1
            square = node + down * width + right
            if least[square] < 0.0:
                _pool(weights, squares, square // width - 1, square % width - 1, shift)
            if least[square] == np.inf:
                continue
            straight = np.float64(least[square]) * side
            over, beside = (2 * down - 1) * width, 2 * right - 1
            across = min(values[node + over + beside], value + SQRT2 * straight)
            along = min(value + straight, 0.5 * (value + across + SQRT2 * straight))
            for other, bound in (
                (node + over, along),
                (node + beside, along),
                (node + over + beside, across),
            ):
                if bound < values[other] - slack:
                    values[other] = bound
                    slot = max(now, int((bound - low) * inverse)) & mask
                    lists = push(heads, entries, costs, lists, slot, other, bound)
                    waiting += 1
    return min(now * step + low, most) if waiting > 0 else most


@njit(cache=True)
def _pool(weights: Floats32, squares: Floats32, row: int, col: int, shift: int) -> None:
    """Find the least weights of the tile of squares about one (row, column)."""
    side, count = 1 << shift, 1 << (_TILE - shift)
    top, left = row // count * count, col // count * count
    low = np.empty((1 << _TILE) + 1, dtype=np.float32)
    for i in range(top, min(top + count, squares.shape[0] - 2)):
        rows = weights[i * side : (i + 1) * side + 1, left * side : (left + count) * side + 1]
        low[:] = np.inf
        for r in range(rows.shape[0]):
            line = rows[r]
            for c in range(line.shape[0]):
                low[c] = line[c] if line[c] < low[c] else low[c]
        for j in range(left, min(left + count, squares.shape[1] - 2)):
            least = np.float32(np.inf)
            for c in range((j - left) * side, (j - left + 1) * side + 1):
                least = min(least, low[c])
            squares[i + 1, j + 1] = least


def shift_for(cells: int) -> int:
    """The shift that finds ways fastest: on large maps a finer bound takes longer than it saves."""
    return _FINE if cells <= _FINE_CELLS else COARSE


@njit(cache=True, inline="always")
def bound_at(values: Floats, width: int, row: int, col: int, shift: int) -> float:
    """The bound at a cell (row, column), of the nodes' flattened values, ``width`` in a row."""
    node = (row >> shift) * width + (col >> shift)
    side = 1 << shift
    i, j = row & (side - 1), col & (side - 1)
    a, b, c, d = values[node], values[node + 1], values[node + width], values[node + width + 1]
    y, x = i * (1.0 / side), j * (1.0 / side)
    if a + d <= b + c:
        if i >= j:
            return float(a + (c - a) * y + (d - c) * x)
        return float(a + (b - a) * x + (d - b) * y)
    if i + j <= side:
        return float(a + (c - a) * y + (b - a) * x)
    return float(d + (b - d) * (1.0 - y) + (c - d) * (1.0 - x))
