"""Steps of an 8-connected grid, compiled: their costs, and those that a search has to try.

A step from cell u to its neighbour v costs length · (w_u + w_v) / 2, as in scikit-image's
MCP_Geometric, and must not cut the corner of a blocked cell. Steps 0 to 3 are straight, 4 to 7
diagonal; the diagonal step i combines the straight steps (i − 4) >> 1 and 2 + (i & 1).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Floats32, Integers
from cohelm.kernels import CACHED, callee

SQRT2 = math.sqrt(2.0)

ANY_STEP = 8
"""Code of the step that led to the start, and to a cell beside other weights."""


@callee()
def octile(rows: int, cols: int) -> float:
    """Length of the shortest 8-connected path over free cells."""
    r, c = abs(rows), abs(cols)
    return float(max(r, c) + (SQRT2 - 1.0) * min(r, c))


@callee()
def neighbours(stride: int) -> tuple[Any, Integers, Integers]:
    """(index offset modulo 2⁶⁴, row step, column step) of the eight steps, straight ones first."""
    rows = np.array([-1, 1, 0, 0, -1, -1, 1, 1])
    cols = np.array([0, 0, -1, 1, -1, 1, -1, 1])
    return (rows * stride + cols).astype(np.uint64), rows, cols


@callee()
def successors() -> tuple[Integers, Integers]:
    """(worthwhile steps after a step (9, 8), number of them (9,)), where weights are uniform.

    If a cell and its eight neighbours have equal weights, most steps are no cheaper than a path
    that avoids the cell. After a straight step only the one ahead is worthwhile: the others are
    longer than the path around, or as long as the one that goes diagonally first. After a diagonal
    step, the one ahead and the two straight steps beside it are. So no straight step of a cheapest
    path is lost, and a diagonal one only if another order of the steps costs the same; one cheapest
    path is always found, whichever of the equal steps to a cell came first. The same pruning is
    used by jump point search (Harabor and Grastien, 2011).
    """
    ahead = np.zeros((9, 8), dtype=np.int64)
    counts = np.ones(9, dtype=np.int64)
    counts[ANY_STEP] = 8
    for i in range(4):
        ahead[i, 0] = i
    for i in range(4, 8):
        ahead[i, 0], ahead[i, 1], ahead[i, 2] = (i - 4) >> 1, 2 + (i & 1), i
        counts[i] = 3
    for i in range(8):
        ahead[ANY_STEP, i] = i
    return ahead, counts


@njit(**CACHED, inline="always")
def is_uniform(weights: Floats32, u: Any, stride: Any) -> bool:
    """Check that a cell of flattened weights and its eight neighbours have equal weights."""
    weight, one = weights[u], np.uint64(1)
    above, below = u - stride, u + stride
    return bool(
        weights[u - one] == weight
        and weights[u + one] == weight
        and weights[above - one] == weight
        and weights[above] == weight
        and weights[above + one] == weight
        and weights[below - one] == weight
        and weights[below] == weight
        and weights[below + one] == weight
    )


@njit(**CACHED, inline="always")
def is_allowed(heavy: float, i: int, free: Booleans) -> bool:
    """Check that step i leads to a cell of a finite weight and cuts no corner.

    ``free`` (4,) holds the straight steps that are allowed. A straight step writes its entry, a
    diagonal one reads two of them, so a search tries the straight steps of a cell first.
    """
    if i < 4:
        free[i] = heavy < np.inf
        return bool(free[i])
    return bool(heavy < np.inf and free[(i - 4) >> 1] and free[2 + (i & 1)])


@callee()
def cheapest_parent(weights: Floats32, reached: Floats, stride: int, u: int) -> tuple[float, int]:
    """(cost so far through it, index) of the neighbour that leads to cell u most cheaply.

    Args:
        weights: (n,), flattened.
        reached: cost so far of each cell, (n,); 0: not reached.
        stride: cells in a row.
        u: index of the cell.

    Returns:
        (∞, −1) if no neighbour was reached.
    """
    best, parent = np.inf, -1
    for dr in range(-1, 2):
        for dc in range(-1, 2):
            v = u + dr * stride + dc
            if v == u or reached[v] == 0.0:
                continue
            half = 0.5
            if dr != 0 and dc != 0:
                if weights[u + dr * stride] + weights[u + dc] == np.inf:
                    continue
                half = 0.5 * SQRT2
            through = reached[v] + half * (np.float64(weights[u]) + np.float64(weights[v]))
            if through < best:
                best, parent = through, v
    return best, parent
