"""Where a reading may have been taken, by trying all places about a guess on a coarse grid."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import compose
from cohelm.perception.outlines import Outline
from cohelm.perception.scan_matching import CELL, Reference


def search(
    reference: Reference, outline: Outline, guess: Floats, reach: float, turn: float
) -> Floats:
    """The pose (3,) of a coarse grid about a guess at which most points lie in full cells.

    Args:
        reference: what was seen before.
        outline: of the reading.
        guess: the middle of the grid.
        reach: half its breadth, m.
        turn: the same of its headings, rad.
    """
    if not len(outline) or not len(reference.outline):
        return guess
    points = outline.points[:: max(len(outline) // 150, 1)]
    full = np.diff(reference.first).reshape(-1, reference.columns) > 0
    best = _search(full, reference.origin, points, guess, np.array([reach, turn]))
    pose: Floats = compose(
        np.array([guess[0] + best[0], guess[1] + best[1], guess[2]]), [0, 0, best[2]]
    )
    return pose


@njit(cache=True)
def _search(
    full: Booleans, origin: Floats, points: Floats, guess: Floats, limits: Floats
) -> Floats:
    """(dx, dy, turn) with the most points in full cells; the nearest to nothing among equals."""
    rows, columns = full.shape
    step, turn = 0.8 * CELL, 0.03
    reach, turns = int(limits[0] / step + 0.5), int(limits[1] / turn + 0.5)
    best, found = -np.inf, np.zeros(3)
    n = points.shape[0]
    x, y = np.empty(n), np.empty(n)
    for t in range(-turns, turns + 1):
        c, s = math.cos(guess[2] + t * turn), math.sin(guess[2] + t * turn)
        for i in range(n):
            x[i] = (guess[0] + c * points[i, 0] - s * points[i, 1] - origin[0]) / CELL
            y[i] = (guess[1] + s * points[i, 0] + c * points[i, 1] - origin[1]) / CELL
        for a in range(-reach, reach + 1):
            for b in range(-reach, reach + 1):
                dx, dy = a * step / CELL, b * step / CELL
                score = -1e-3 * (abs(t) + abs(a) + abs(b))
                for i in range(n):
                    column, row = math.floor(x[i] + dx), math.floor(y[i] + dy)
                    if 0 <= column < columns and 0 <= row < rows and full[int(row), int(column)]:
                        score += 1.0
                if score > best:
                    best = score
                    found[0], found[1], found[2] = a * step, b * step, t * turn
    return found
