"""Lower bound of the cost from every cell to the goal, at a quarter or eighth of the resolution.

The bound is a function h on the map, given by values at every fourth or eighth cell in both
directions. In a square between four such nodes, h is linear on two triangles: the square is cut
along the diagonal with the lower sum of its ends. A function that decreases along no step by more
than the cost of the step, and is zero at the goal, is a consistent lower bound. With w the lowest
weight in the square, including its border, and a the side of the square, this requires in each
triangle a gradient (p, q) with

    |p| ≤ w,  |q| ≤ w,  |p + q| ≤ √2 w,  |p − q| ≤ √2 w.

For the values x, m, y, z of the nodes of a square, x and y beside m and z opposite to it, that is

    x ≤ m + w a,      z ≤ m + √2 w a,      2 x ≤ m + z + √2 w a,

each for every corner in the role of x or m. The third holds for the cut from m to z; its condition
on the two other nodes, m + z ≤ 2 x + √2 w a, follows from m + z ≤ x + y, the rule that chooses the
cut. All three bound a node by a function that increases with other nodes and exceeds them, so the
greatest solution is found like shortest paths. On an empty floor h is the octile distance. A capped
h is still a bound, so nodes much farther than the start are left out. Except for rounding, the
search that uses h is therefore exact.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.array_kernels import NONE, ZERO
from cohelm.arrays import Floats, Floats32
from cohelm.kernels import CACHED, callee
from cohelm.planning.grid_search.bucket_queue import (
    SLACK,
    bucket_ring,
    pop,
    push,
)
from cohelm.planning.grid_search.grid_steps import SQRT2, octile

COARSE_SHIFT = 3
"""Shift from a cell's row and column to those of its square: squares of eight by eight cells."""

_FINE, _FINE_CELLS = 2, 1 << 21
_TILE = 7  # shift to the tiles whose squares' lowest weights are computed together
_UNKNOWN = np.float32(-1.0)
_MARGIN = 1.02  # times the start's own bound: nodes beyond are left out


@njit(**CACHED)
def lower_bound(
    weights: Floats32,
    start: tuple[int, int],
    goal: tuple[int, int],
    lightest: float,
    heaviest: float,
    shift: int,
) -> Floats:
    """Values at the nodes, inf where no path leads, to be read with :func:`bound_at`.

    All bounds are too great by the same number, namely the value at the goal.

    Args:
        weights: (rows, cols), with a blocked border.
        start, goal: (row, column) in ``weights``.
        lightest, heaviest: lower and upper bound of the passable weights.
        shift: from a cell's row and column to those of its square.
    """
    squares, nodes = empty_nodes(weights, shift)
    near = (start[0] >> shift) * nodes.shape[1] + (start[1] >> shift)
    capacity, reach = nodes.size + 64, -np.inf
    while reach == -np.inf:
        nodes[:] = np.inf
        seed_goal(weights, squares, nodes, goal, shift)
        reach = propagate(
            weights, squares, nodes, near, lightest, heaviest, np.inf, capacity, shift
        )
        capacity *= 4
    cap_nodes(nodes, reach)
    return nodes


@callee()
def empty_nodes(weights: Floats32, shift: int) -> tuple[Floats32, Floats]:
    """(squares whose lowest weights are not computed yet, nodes at infinity) of a grid.

    Node (i, j) has index k = i · width + j, and the squares around it have k and, with the border,
    k + 1, k + width and k + width + 1.
    """
    rows, cols = weights.shape
    side = 1 << shift
    down, across = (rows + side - 2) >> shift, (cols + side - 2) >> shift  # squares
    squares = np.full((down + 2, across + 2), np.inf, dtype=np.float32)
    squares[1:-1, 1:-1] = _UNKNOWN
    return squares, np.full((down + 1, across + 2), np.inf)


@callee()
def seed_goal(
    weights: Floats32, squares: Floats32, nodes: Floats, goal: tuple[int, int], shift: int
) -> None:
    """Set the nodes around the goal."""
    row, col = goal[0] >> shift, goal[1] >> shift
    _min_weights(weights, squares, row, col, shift)
    for i in range(row, row + 2):
        for j in range(col, col + 2):
            away = octile((i << shift) - goal[0], (j << shift) - goal[1])
            nodes[i, j] = np.float64(squares[row + 1, col + 1]) * away


@callee()
def cap_nodes(nodes: Floats, most: float) -> None:
    """Limit all nodes to a highest value."""
    for i in range(nodes.shape[0]):
        for j in range(nodes.shape[1]):
            nodes[i, j] = min(nodes[i, j], most)


@callee()
def propagate(  # noqa: PLR0912  # one hot loop over plain arrays
    weights: Floats32,
    squares: Floats32,
    nodes: Floats,
    near: int,
    lightest: float,
    heaviest: float,
    most: float,
    capacity: int,
    shift: int,
) -> float:
    """Lower ``nodes``, some of them finite, to the greatest solution below them.

    Args:
        weights, squares: of the grid; lowest weights of squares are computed when needed.
        nodes: changed in place.
        near: first of the four nodes of the square where to stop, with a margin; −1: none.
        lightest, heaviest: lower and upper bound of the passable weights.
        most: highest value to compute.
        capacity: of the open list.
        shift: from a cell's row and column to those of its square.

    Returns:
        The value up to which the nodes are correct; greater ones must be limited to it. −inf if
        the capacity is too small.
    """
    side, width = float(1 << shift), nodes.shape[1]
    values, least = nodes.reshape(-1), squares.reshape(-1)
    # Count the finite nodes and find their range.
    low, high, waiting = np.inf, -np.inf, 0
    for node in range(values.shape[0]):
        if values[node] <= most and values[node] < np.inf:
            low, high, waiting = min(low, values[node]), max(high, values[node]), waiting + 1
    if waiting == 0:
        return most
    if waiting + 12 > capacity:
        return -np.inf
    # Create the open list, whose keys start at the lowest value.
    heads, step = bucket_ring(0.5 * lightest * side, high - low + SQRT2 * heaviest * side)
    entries, costs = np.empty((capacity, 2), dtype=np.int64), np.empty(capacity)
    lists = (NONE, ZERO)
    mask, inverse, slack = heads.shape[0] - 1, 1.0 / step, SLACK * lightest
    # Queue the finite nodes.
    for node in range(values.shape[0]):
        value = values[node]
        if value <= most and value < np.inf:
            slot = int((value - low) * inverse) & mask
            lists = push(heads, entries, costs, lists, slot, node, value)
    now, last = 0, 1 << 62
    if most < np.inf:
        last = int((most - low) * inverse)
    while waiting > 0 and now <= last:
        if lists[1] + 12 > capacity:
            return -np.inf
        # Take the newest entry of the lowest bucket, unless it is stale.
        entry = heads[now & mask]
        if entry < 0:
            now += 1
            continue
        lists = pop(heads, entries, lists, now & mask)
        waiting -= 1
        node, value = entries[entry, 0], costs[entry]
        if values[node] != value:
            continue
        # A node of the start's square is final: a margin above it is enough.
        if near >= 0 and node - near in (0, 1, width, width + 1):
            last = min(last, int((_MARGIN * value + side * lightest - low) * inverse) + 1)
            near = -1
        # Lower the three other nodes of each of the four squares around the node.
        for q in range(4):
            down, right = q >> 1, q & 1
            square = node + down * width + right
            if least[square] < 0.0:
                _min_weights(weights, squares, square // width - 1, square % width - 1, shift)
            if least[square] == np.inf:
                continue
            # Bounds of the opposite node (across) and of the two between (along).
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


@callee()
def _min_weights(weights: Floats32, squares: Floats32, row: int, col: int, shift: int) -> None:
    """Compute the lowest weights in the tile of squares around one (row, column)."""
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
    """Shift with the fastest search: on large maps a finer bound takes longer than it saves."""
    return _FINE if cells <= _FINE_CELLS else COARSE_SHIFT


@njit(**CACHED, inline="always")
def bound_at(values: Floats, width: int, row: int, col: int, shift: int) -> float:
    """Bound at a cell (row, column) from the nodes' flattened values, ``width`` in a row."""
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
