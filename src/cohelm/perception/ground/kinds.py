"""Kernels of the ground map: what wheels can do in each cell."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Bytes, Floats
from cohelm.kernels import CACHED, callee
from cohelm.perception.ground.cells import (
    FLOOR,
    HIGHER,
    LOWER,
    OBJECT,
    SEEN,
    UNSEEN,
    GroundCells,
    GroundRules,
)

_STEPS = np.array(
    [
        [0, 2],
        [2, 0],
        [2, 2],
        [2, -2],
        [0, 4],
        [4, 0],
        [3, 3],
        [3, -3],
        [0, 8],
        [8, 0],
        [0, 16],
        [16, 0],
    ]
)
"""Offsets (rows, columns) at which cells are compared, each pair once."""
_BESIDE = np.array([[0, 1], [1, 1], [1, 0], [1, -1], [0, -1], [-1, -1], [-1, 0], [-1, 1]])
_BLOCK = 16
"""Side of the blocks in which steps are looked for, cells: no offset is longer."""
_NEAR = 4
"""Distance in cells within which floor vouches for an unseen cell beside it."""
_ALONG, _SPECK = 3, 4
"""Distance in cells within which so many cells must lie behind an edge: a single one is noise."""
_LONG, _STRAIGHT = 16, 0.02
"""Cells over which a slope is measured, and how far its middle may be off, m."""
_STICKY = 0.01
"""A cell behind an edge stays one while its step is at most this much too small, m."""


@njit(**CACHED)
def update_kinds(cells: GroundCells, chair: Floats, level: float, rules: GroundRules) -> int:
    """Decide what wheels can do in each cell, in place; return how many edges changed.

    Of two cells with a step between them the one counts as behind it whose height differs more
    from that of the chair. An unseen cell that a ray passed far below its neighbours lies behind an
    edge, and so does one between such cells and floor.

    Args:
        cells: of the map.
        chair: (2,), its place in the window's frame, m.
        level: height of the floor under it, m.
        rules: of the map.
    """
    rows, cols = cells.height.shape
    kind, before = cells.kind, cells.kind.copy()
    for r in range(rows):
        for c in range(cols):
            kind[r, c] = FLOOR if cells.seen[r, c] > 0 else UNSEEN
    uneven = _uneven_blocks(cells, min(rules.down, rules.up) - _STICKY)
    for k in range(_STEPS.shape[0]):
        _mark_steps(cells, before, uneven, (_STEPS[k, 0], _STEPS[k, 1]), level, rules)
    _mark_passed(cells, before, chair, level, rules)
    _drop_specks(cells)
    _close_gaps(cells)
    changed = 0
    for r in range(rows):
        for c in range(cols):
            changed += (kind[r, c] >= LOWER) != (before[r, c] >= LOWER)
    return changed


@callee()
def _uneven_blocks(cells: GroundCells, step: float) -> Booleans:
    """Blocks of ``_BLOCK`` cells a side with a step this high in them or to a later neighbour."""
    rows, cols = cells.height.shape
    shape = ((rows + _BLOCK - 1) // _BLOCK, (cols + _BLOCK - 1) // _BLOCK)
    low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
    for r in range(rows):
        for c in range(cols):
            if cells.seen[r, c] >= SEEN:
                i, j, height = r // _BLOCK, c // _BLOCK, cells.height[r, c]
                low[i, j], high[i, j] = min(low[i, j], height), max(high[i, j], height)
    out = np.zeros(shape, dtype=np.bool_)
    for i in range(shape[0]):
        for j in range(shape[1]):
            least, most = np.inf, -np.inf
            for m in range(i, min(i + 2, shape[0])):
                for n in range(max(j - 1, 0), min(j + 2, shape[1])):
                    least, most = min(least, low[m, n]), max(most, high[m, n])
            out[i, j] = most - least > step
    return out


@callee()
def _mark_steps(
    cells: GroundCells,
    before: Bytes,
    uneven: Booleans,
    offset: tuple[int, int],
    level: float,
    rules: GroundRules,
) -> None:
    """Compare all cells with those at an offset, and mark what lies behind a step or a steep slope.

    A step is no longer than a few cells. Cells farther apart have one between them only where
    nothing was seen between them; where their middle was seen, halfway up, they show the slope.
    """
    height, seen, kind = cells.height, cells.seen, cells.kind
    rows, cols = height.shape
    away = max(abs(offset[0]), abs(offset[1]))
    allowed = rules.slope * max(away - _NEAR, 0) * rules.resolution
    least = min(rules.down, rules.up) + allowed - _STICKY
    for block in np.ndindex(uneven.shape):
        if not uneven[block]:
            continue
        first, left = block[0] * _BLOCK, max(block[1] * _BLOCK, -offset[1])
        right = min((block[1] + 1) * _BLOCK, cols - max(offset[1], 0))
        for r in range(first, min(first + _BLOCK, rows - offset[0])):
            for c in range(left, right):
                i, j = r + offset[0], c + offset[1]
                step = height[i, j] - height[r, c]
                if abs(step) <= least or seen[r, c] < SEEN or seen[i, j] < SEEN:
                    continue
                y, x = (r + i) // 2, (c + j) // 2
                if away > _NEAR and seen[y, x] >= SEEN:
                    off = height[y, x] - 0.5 * (height[r, c] + height[i, j])
                    if away < _LONG or abs(off) > _STRAIGHT:
                        continue
                # The one that is farther from the chair's level lies behind the step.
                if abs(height[r, c] - level) > abs(height[i, j] - level):
                    m, n, i, j, step = i, j, r, c, -step
                else:
                    m, n = r, c
                sticky = _STICKY if before[i, j] >= LOWER else 0.0
                if -step > rules.down + allowed - sticky:
                    if cells.tall[m, n] == 0:  # an object's foot is not the floor's height
                        kind[i, j] = LOWER
                elif step > rules.up + allowed - sticky and kind[i, j] != LOWER:
                    kind[i, j] = OBJECT if _is_tall(cells, i, j) else HIGHER


@callee()
def _is_tall(cells: GroundCells, r: int, c: int) -> bool:
    """Check for a high object within a foot's length: what is low there belongs to it."""
    rows, cols = cells.tall.shape
    for i in range(max(r - 4, 0), min(r + 5, rows)):
        for j in range(max(c - 4, 0), min(c + 5, cols)):
            if cells.tall[i, j] > 0:
                return True
    return False


@callee()
def _mark_passed(
    cells: GroundCells, before: Bytes, chair: Floats, level: float, rules: GroundRules
) -> None:
    """Mark cells that rays passed below the floor near them, or below the chair's slope.

    Floor that was only assumed, or seen once, does not hold against them.
    """
    rows, cols = cells.height.shape
    top, bottom, left, right = rows, -1, cols, -1
    for r in range(rows):
        for c in range(cols):
            if cells.seen[r, c] < SEEN and cells.passed[r, c] >= SEEN:
                top, bottom = min(top, r), max(bottom, r)
                left, right = min(left, c), max(right, c)
    floor = np.full((rows, max(right - left + 1, 0)), -np.inf)
    for r in range(max(top - _NEAR, 0), min(bottom + _NEAR + 1, rows)):
        for c in range(left, right + 1):
            for j in range(max(c - _NEAR, 0), min(c + _NEAR + 1, cols)):
                if cells.kind[r, j] == FLOOR and cells.tall[r, j] == 0:
                    floor[r, c - left] = max(floor[r, c - left], cells.height[r, j])
    for r in range(top, bottom + 1):
        for c in range(left, right + 1):
            if cells.seen[r, c] >= SEEN or cells.passed[r, c] < SEEN:
                continue
            beside = -np.inf
            for i in range(max(r - _NEAR, 0), min(r + _NEAR + 1, rows)):
                beside = max(beside, floor[i, c - left])
            if beside == -np.inf:
                x, y = (c + 0.5) * rules.resolution, (r + 0.5) * rules.resolution
                beside = level - rules.slope * math.hypot(x - chair[0], y - chair[1])
            sticky = _STICKY if before[r, c] == LOWER else 0.0
            if cells.bound[r, c] < beside - rules.down + sticky:
                cells.kind[r, c] = LOWER


@callee()
def _drop_specks(cells: GroundCells) -> None:
    """Count single cells behind an edge as floor or unseen: edges are lines, noise is not."""
    rows, cols = cells.kind.shape
    found = cells.kind.copy()
    for r in range(rows):
        for c in range(cols):
            if found[r, c] < LOWER:
                continue
            beside = 0
            for i in range(max(r - _ALONG, 0), min(r + _ALONG + 1, rows)):
                for j in range(max(c - _ALONG, 0), min(c + _ALONG + 1, cols)):
                    beside += found[i, j] == found[r, c]
            if beside < _SPECK:
                cells.kind[r, c] = FLOOR if cells.seen[r, c] > 0 else UNSEEN


@callee()
def _close_gaps(cells: GroundCells) -> None:
    """Count unseen cells in the way from floor to what lies lower as lower, in place.

    So does the cell before an edge: a return just before it may come from just behind it. Edges
    that were remembered have their gaps closed already, and would grow each time they come back.
    """
    kind = cells.kind
    rows, cols = kind.shape
    top, bottom, left, right = rows, -1, cols, -1
    for r in range(rows):
        for c in range(cols):
            if kind[r, c] == LOWER:
                top, bottom = min(top, r), max(bottom, r)
                left, right = min(left, c), max(right, c)
    for k in range(_NEAR):
        found = kind.copy()
        for r in range(max(top - k - 1, 1), min(bottom + k + 2, rows - 1)):
            for c in range(max(left - k - 1, 1), min(right + k + 2, cols - 1)):
                if found[r, c] == UNSEEN or (k == 0 and found[r, c] == FLOOR):
                    for m in range(_BESIDE.shape[0]):
                        i, j = r + _BESIDE[m, 0], c + _BESIDE[m, 1]
                        if found[i, j] == LOWER and cells.bound[i, j] > -np.inf:
                            kind[r, c] = LOWER
                            break
