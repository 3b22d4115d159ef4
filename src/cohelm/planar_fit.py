"""Least squares for a motion (x, y, turn) in the plane: one row for each distance to a line.

Fits of scans to maps, to earlier scans and to features share it. A row says that a point lies
``e`` from a line with unit normal (nx, ny); its derivative with respect to the turn is
``ny · rx − nx · ry`` for a point (rx, ry) relative to the centre of the turn.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED


@njit(**CACHED, inline="always")
def add_row(
    H: Floats, g: Floats, nx: float, ny: float, turn: float, e: float, weight: float
) -> None:
    """Add one row to the upper triangle of H (3, 3) and to the gradient g (3,).

    Args:
        H, g: normal equations.
        nx, ny: unit normal of the line.
        turn: derivative of the distance with respect to the turn, m.
        e: distance, m.
        weight: of the row.
    """
    H[0, 0] += weight * nx * nx
    H[0, 1] += weight * nx * ny
    H[1, 1] += weight * ny * ny
    H[0, 2] += weight * nx * turn
    H[1, 2] += weight * ny * turn
    H[2, 2] += weight * turn * turn
    g[0] += weight * nx * e
    g[1] += weight * ny * e
    g[2] += weight * turn * e


@njit(**CACHED)
def newton_step(H: Floats, g: Floats) -> Floats:
    """Step (3,) to add to the motion; completes the lower triangle of H, which must be regular."""
    H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]
    step = np.empty(3)
    step[:] = -np.linalg.solve(H, g)
    return step
