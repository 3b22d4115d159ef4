"""Openings where the map has a wall, the scanner sees through it, and the rider pushes on.

A map grows old: a door is moved, a partition is taken away. That beams pass a mapped wall is not
enough to drive through it, because a wall of glass looks the same. So it takes the rider's word as
well: a stick that moves nothing for a second opens the cells at hand through which the scan passes.
The chair then feels its way for some seconds.

Cells where beams end close again. Keepout zones never open.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit

from cohelm.arrays import (
    Annotated,
    Booleans,
    Floats,
    Floats32,
    Integers,
    Shape,
    identical,
    read_only,
    value,
)
from cohelm.geometry import inverse, transform
from cohelm.kernels import CACHED
from cohelm.maps import DistanceField, OccupancyGrid, signed_distance
from cohelm.perception import Detections
from cohelm.perception.obstacles.cells import beam_buffers, crossed_cells

_SWEEPS = 5
"""Number of sweeps that pass a cell from which no wall is seen there: half a second at 10 Hz."""
_HELD = 1.0
"""Time for which a stick moves nothing before walls open, s."""
_SLOW = 5.0
"""Time for which the chair then drives slowly, s: long enough for its front to pass the wall."""
OPENING_SPEED = 0.1
"""Speed at that time, m/s: the map may be right, and the wall of glass."""
_AT_HAND, _REACH = 1.0, 2.5
"""Distance from the sensor up to which a push opens cells, m, and up to which those beside them
do."""
_BEHIND = 0.3
"""Distance that a beam must go on beyond a mapped wall, m: a grazing one does not."""
_GROWS = 2
"""Distance from an open cell within which others open without a push, in cells."""
_AROUND = 4.0
"""Distance from open cells up to which the distance field changes, m: as far as planners look."""


@value
class FreeCells:
    """Walls of the map that are not there; the same object while nothing changes."""

    codes: Annotated[Integers, Shape("k")]
    """Row · columns + column of each, ascending."""


@value
class MapOpenings:
    """Mapped walls through which the scan passes."""

    passed: Annotated[Integers, Shape("k")]
    """Codes of cells, ascending."""
    sweeps: Annotated[Integers, Shape("k")]
    """Sweeps that passed each, up to a bound."""
    opened: FreeCells
    """Those where the rider has pushed on."""
    seen: FreeCells
    """These, and those that enough sweeps have passed."""
    held_since: float = math.inf
    """Time since which a deflected stick moves nothing, s."""
    slow_until: float = -math.inf
    """Time until which the chair feels its way after a push has opened something, s."""


_NONE = np.empty(0, dtype=np.int64)
NO_CELLS = FreeCells(codes=_NONE)
CLOSED = MapOpenings(passed=_NONE, sweeps=_NONE, opened=NO_CELLS, seen=NO_CELLS)


def update_openings(
    before: MapOpenings,
    detections: tuple[Detections, ...],
    grid: OccupancyGrid,
    openable: Booleans,
    *,
    pushes: bool,
    held_since: float,
) -> MapOpenings:
    """Count the sweeps that pass mapped walls; return ``before`` itself if nothing changes.

    Args:
        before: result of the last call.
        detections: of each new sweep; clouds say nothing of a wall's height.
        grid: the map.
        openable: (rows, cols) its walls that are no keepout zone.
        pushes: the stick of a rider who is helped is deflected; otherwise only what is open counts.
        held_since: time since which it moves nothing, s; +inf: it does.
    """
    opened = before.opened.codes
    if not pushes and not len(opened):
        return CLOSED
    sweeps = [each for each in detections if each.heights is None]
    if not sweeps:
        return before
    passed, counts = before.passed, before.sweeps
    for found in sweeps:
        through, hit = _passed_and_hit(found, grid, openable)
        passed, counts = _counted(passed, counts, through, hit)
        opened = opened[~np.isin(opened, hit)]
    columns = grid.shape[1]
    beside = _beside(passed, opened, columns)
    if not pushes:
        passed, counts, beside = passed[beside], counts[beside], beside[beside]
    held = sweeps[-1].time - held_since >= _HELD
    at_hand = held & (_distances(passed, sweeps[-1], grid) < _AT_HAND)
    sure = counts >= _SWEEPS
    opens = sure & at_hand & ~np.isin(passed, opened) & ~beside
    slow_until = sweeps[-1].time + _SLOW if opens.any() else before.slow_until
    opened = np.union1d(opened, passed[sure & (beside | at_hand)])
    if not len(passed) and not len(opened) and math.isinf(held_since):
        return CLOSED
    return MapOpenings(
        passed=passed,
        sweeps=counts,
        opened=_same(before.opened, opened),
        seen=_same(before.seen, np.union1d(opened, passed[sure])),
        held_since=held_since,
        slow_until=slow_until,
    )


def _same(before: FreeCells, codes: Integers) -> FreeCells:
    return before if identical(before.codes, codes) else FreeCells(codes=codes)


def _counted(
    passed: Integers, counts: Integers, through: Integers, hit: Integers
) -> tuple[Integers, Integers]:
    """Add one sweep to the cells that were passed, and to the number of sweeps."""
    every = np.union1d(passed, through)
    sweeps = np.isin(every, through).astype(np.int64)
    sweeps[np.isin(every, passed)] += counts
    kept = ~np.isin(every, hit)
    return every[kept], np.minimum(sweeps[kept], _SWEEPS)


def _beside(passed: Integers, opened: Integers, columns: int) -> Booleans:
    """Mask (k,) of the cells beside one that is open."""
    if not len(opened) or not len(passed):
        return np.zeros(len(passed), dtype=np.bool_)
    rows = np.abs(passed[:, None] // columns - opened // columns)
    cols = np.abs(passed[:, None] % columns - opened % columns)
    beside: Booleans = np.maximum(rows, cols).min(axis=1) <= _GROWS
    return beside


def _distances(codes: Integers, found: Detections, grid: OccupancyGrid) -> Floats:
    """Distances (k,) of cells from a sensor, m."""
    x, y = transform(inverse(grid.X_MG), found.origin)
    columns, side = grid.shape[1], grid.resolution
    dx, dy = (codes % columns + 0.5) * side - x, (codes // columns + 0.5) * side - y
    return np.asarray(np.hypot(dx, dy), dtype=float)


def _passed_and_hit(
    found: Detections, grid: OccupancyGrid, openable: Booleans
) -> tuple[Integers, Integers]:
    """Codes of the walls that a sweep passes, and of those where its beams end.

    Only beams with a return count: a scanner that fails sees no wall either.
    """
    X_GM, side = inverse(grid.X_MG), grid.resolution
    origin = transform(X_GM, found.origin) / side
    ends = transform(X_GM, found.points) / side
    around = np.array([1.0, 1.0]) * (_REACH + _BEHIND) / side
    low = np.maximum(np.floor(origin - around).astype(np.int64), 0)
    (c0, r0), (c1, r1) = low, np.ceil(origin + around).astype(np.int64)
    near = np.ascontiguousarray(openable[r0 : max(r1, r0), c0 : max(c1, c0)])
    if not near.any():
        return _NONE, _NONE
    passed, hit = np.zeros_like(near), np.zeros_like(near)
    limits = (_REACH / side, _BEHIND / side)
    _mark(near, origin - low, ends - low, limits, passed, hit)
    return _codes(passed & ~hit, r0, c0, grid), _codes(hit, r0, c0, grid)


def _codes(mask: Booleans, row: int, column: int, grid: OccupancyGrid) -> Integers:
    """Codes of the marked cells of a window that begins at a row and column, in their order."""
    rows, cols = np.nonzero(mask)
    codes: Integers = (rows + row) * grid.shape[1] + cols + column
    return codes


@njit(**CACHED)
def _mark(  # a kernel takes plain arrays
    openable: Booleans,
    origin: Floats,
    ends: Floats,
    limits: tuple[float, float],
    passed: Booleans,
    hit: Booleans,
) -> None:
    """Mark the cells that beams pass and hit, in place.

    Args:
        openable: (rows, cols).
        origin: (column, row) of the sensor.
        ends: (p, 2) (column, row) of the returns.
        limits: reach, and the last part of a beam that passes nothing, in cells.
        passed: (rows, cols).
        hit: (rows, cols).
    """
    rows, cols = openable.shape
    reach, behind = limits
    cells, at = beam_buffers(origin, ends)
    for i in range(ends.shape[0]):
        away = ends[i] - origin
        length = np.hypot(away[0], away[1])
        if length < reach + behind:
            c, r = int(np.floor(ends[i, 0])), int(np.floor(ends[i, 1]))
            if 0 <= r < rows and 0 <= c < cols:
                hit[r, c] = openable[r, c]
        margin = max(behind, length - reach)
        for k in range(crossed_cells(origin, ends[i], margin, cells, at)):
            r, c = cells[k, 0], cells[k, 1]
            if 0 <= r < rows and 0 <= c < cols and openable[r, c]:
                passed[r, c] = True


def with_openings(
    window: Floats32, corner: Integers, static: DistanceField, free: FreeCells
) -> Floats32:
    """Distance field of a window with open cells as free floor; the window itself without any.

    Args:
        window: (rows, cols) distances of the map, m.
        corner: (row, column) of its first cell.
        static: distance field of the whole map.
        free: open cells.
    """
    opened = _opened(static, free)
    if opened is None:
        return window
    first, distance = opened
    low = np.maximum(corner, first)
    high = np.minimum(corner + window.shape, first + distance.shape)
    if (high <= low).any():
        return window
    out = window.copy()
    (a, b), (c, d) = low - corner, high - corner
    (e, f), (g, h) = low - first, high - first
    np.maximum(out[a:c, b:d], distance[e:g, f:h], out=out[a:c, b:d])
    return out


@lru_cache(maxsize=4)
def _opened(static: DistanceField, free: FreeCells) -> tuple[Integers, Floats32] | None:
    """(corner, distances) of the map about the open cells; None without any.

    Walls beyond the part that is computed are no nearer than its border, nor than before.
    """
    if not len(free.codes):
        return None
    cells = np.column_stack(np.divmod(free.codes, static.distance.shape[1]))
    around = round(_AROUND / static.resolution)
    first = np.maximum(cells.min(axis=0) - around, 0)
    end = np.minimum(cells.max(axis=0) + around + 1, static.distance.shape)
    before = static.distance[first[0] : end[0], first[1] : end[1]]
    blocked = before <= 0.0
    rows, cols = (cells - first).T
    blocked[rows, cols] = False
    border = np.minimum.outer(
        *(_to_border(*ends) for ends in zip(first, end, static.distance.shape, strict=True))
    )
    bound = np.maximum(before, (border * static.resolution).astype(np.float32))
    return first, read_only(np.minimum(signed_distance(blocked, static.resolution), bound))


def _to_border(first: int, end: int, size: int) -> Floats:
    """Cells from each row or column of a part to its border; that of the map is none."""
    at = np.arange(first, end)
    before = at - first if first > 0 else np.inf
    after = end - 1 - at if end < size else np.inf
    return np.minimum(before, after) + np.zeros(len(at))
