"""Weights of grid cells, packed for the searches, and the paths that the searches return."""

from __future__ import annotations

from dataclasses import field

import numpy as np
from numba import njit

from cohelm.arrays import (
    Annotated,
    Bytes,
    Floats32,
    Integers,
    Shape,
    empty_for_copies,
    value,
)
from cohelm.kernels import CACHED
from cohelm.planning.grid_search.grid_steps import SQRT2

BLOCKED = np.float32(np.inf)
"""Weight of a cell that must not be entered."""


@value
class GridPath:
    """Optimal path over a grid."""

    cells: Annotated[Integers, Shape("k 2")]
    """(row, column), including start and goal."""
    cost: float
    """Weighted length in cells (times the resolution: m), summed in float64 along the cells."""
    expansions: int
    """Number of expansions; a cell may be expanded several times."""
    waypoints: Annotated[Integers, Shape("p")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Increasing indices of cells that the refined line must pass within one cell: the search
    accepted extra cost to reach them, so neither shortening nor smoothing may move them away."""


@value
class Weights:
    """Weight of each cell, packed for the searches."""

    packed: Annotated[Floats32, Shape("rows cols")]
    """The grid with a blocked border one cell wide; > 0; ``BLOCKED`` where impassable."""
    lightest: float
    """Lower bound of all passable weights, > 0; a tighter bound makes the search faster."""
    heaviest: float
    """Upper bound of all passable weights."""

    @staticmethod
    def of_costs(cost: Bytes, table: Floats32) -> Weights:
        """Weights of costs (rows, cols) by a table (256,) whose blocked entries are infinite."""
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
        """Weights from an array (rows, cols).

        Raises:
            ValueError: if one is not positive.
        """
        if not bool((weights > 0.0).all()):
            raise ValueError("weights must be positive")
        packed = np.pad(weights, 1, constant_values=BLOCKED)
        passable = weights[np.isfinite(weights)]
        low, high = (passable.min(), passable.max()) if passable.size else (1.0, 1.0)
        return Weights(packed=packed, lightest=float(low), heaviest=float(high))


@njit(**CACHED)
def pack_costs(cost: Bytes, table: Floats32, packed: Floats32, row: int, col: int) -> None:
    """Write the weights of a window's costs into packed weights.

    Args:
        cost: costs of the window.
        table: weights (256,) of costs.
        packed: (rows + 2, cols + 2), changed in place.
        row, col: first cell of the window on the grid.
    """
    for r in range(cost.shape[0]):
        for c in range(cost.shape[1]):
            packed[row + r + 1, col + c + 1] = table[cost[r, c]]


@njit(**CACHED)
def path_cost(weights: Floats32, cells: Integers) -> float:
    """Cost of a path (k, 2) over packed weights, in cells, summed in float64."""
    total = 0.0
    for i in range(cells.shape[0] - 1):
        r0, c0, r1, c1 = cells[i, 0], cells[i, 1], cells[i + 1, 0], cells[i + 1, 1]
        half = 0.5 * SQRT2 if r0 != r1 and c0 != c1 else 0.5
        total += half * (np.float64(weights[r0 + 1, c0 + 1]) + np.float64(weights[r1 + 1, c1 + 1]))
    return total
