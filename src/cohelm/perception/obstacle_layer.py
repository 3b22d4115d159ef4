"""The live obstacle layer: what stands about the chair that is neither in the map nor a person.

A rolling window on the map's cells holds for each an evidence of 0…``most``. A return that neither
the map nor a person explains adds to its cell's, a beam that crosses a cell takes from it, and what
is out of view is kept. A cell becomes occupied and free at two different levels, so that neither
one noisy return nor one stray beam flips it. Tracked people are wiped out of it, cells that they
covered before they were recognised included; what is not (yet) tracked as a person is an obstacle.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Booleans, Bytes, Floats, Integers, Shape, SignedBytes, value
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import LiveObstacles, People
from cohelm.perception.api import Detections


class ObstacleLayerParameters(Model):
    """Of the layer; assumed."""

    side: float = Field(20.0, gt=1.0, le=200.0)
    """Of the square window, m."""
    hit: int = Field(3, ge=1, le=60)
    """Evidence that returns in a cell add in one scan."""
    miss: int = Field(1, ge=1, le=60)
    """Evidence that beams across a cell take in one scan."""
    most: int = Field(9, ge=1, le=127)
    """Greatest evidence: what is gone is cleared after ``most / miss`` scans that look there."""
    occupied_from: int = Field(5, ge=1, le=127)
    """Evidence at which a cell becomes occupied; it becomes free again at 0."""
    end_margin: float = Field(0.1, ge=0.0, le=1.0)
    """The last part of a beam clears nothing, m."""
    end_margin_growth: float = Field(0.01, ge=0.0, le=0.2)
    """Growth of that part with range, m/m."""
    person_margin: float = Field(0.2, ge=0.0, le=1.0)
    """Returns this near a tracked body are the person's, m."""
    person_reach: float = Field(0.5, ge=0.0, le=2.0)
    """A detection whose centre is this near a tracked person's is that person, m."""


DEFAULTS = ObstacleLayerParameters()

_Cells = TypeVar("_Cells", SignedBytes, Bytes)


@value
class ObstacleLayerState:
    """The layer's memory."""

    evidence: Annotated[SignedBytes, Shape("rows cols")]
    obstacles: LiveObstacles
    """What the rest of the system reads; the same object as long as nothing changes."""


def update_obstacle_layer(
    layer: ObstacleLayerState | None,
    detections: tuple[Detections, ...],
    people: People,
    grid: OccupancyGrid,
    position: Floats,
    parameters: ObstacleLayerParameters = DEFAULTS,
) -> ObstacleLayerState:
    """The layer after some scans; ``layer`` itself where nothing changes.

    Args:
        layer: as it was, None at first.
        detections: of each new scan; may be none.
        people: the tracked ones, now.
        grid: the map, whose cells the window consists of.
        position: (2,) or a pose (3,), where the robot is, m; the window goes with it.
        parameters: of the layer.
    """
    p = parameters
    corner = _corner(grid, np.asarray(position, dtype=float)[:2], p.side)
    if layer is None:
        n = _cells_a_side(grid, p.side)
        none = LiveObstacles(corner=corner, occupied=np.zeros((n, n), dtype=np.uint8), version=0)
        layer = ObstacleLayerState(evidence=np.zeros((n, n), dtype=np.int8), obstacles=none)
    rolled = _rolled(layer, corner)
    if not detections:
        return rolled
    evidence, occupied = rolled.evidence.copy(), rolled.obstacles.occupied.copy()
    X_WM = _window_from_map(grid, rolled.obstacles.corner)
    bodies = np.column_stack([_in_cells(X_WM, people.mean[:, :2], grid), people.radius])
    for seen in detections:
        _look(evidence, seen, ~_unexplained(seen, people, p), X_WM, grid, p)
    _wipe(evidence, bodies, grid.resolution)
    if not _decide(evidence, occupied, p.occupied_from):
        occupied = rolled.obstacles.occupied
    return _next(rolled, evidence, occupied)


def _look(
    evidence: SignedBytes,
    seen: Detections,
    explained: Booleans,
    X_WM: Floats,
    grid: OccupancyGrid,
    p: ObstacleLayerParameters,
) -> None:
    """Put one scan into ``evidence``, in place."""
    ends = np.concatenate([seen.points, seen.through])
    margin = p.end_margin + p.end_margin_growth * np.hypot(*(ends - seen.origin).T)
    margin[len(seen.points) :] = 0.0
    _mark_and_clear(
        evidence,
        _in_cells(X_WM, seen.origin, grid),
        _in_cells(X_WM, ends, grid),
        np.concatenate([explained, np.ones(len(seen.through), dtype=np.bool_)]),
        margin / grid.resolution,
        np.array([p.hit, p.miss, p.most]),
    )


def _unexplained(seen: Detections, people: People, p: ObstacleLayerParameters) -> Booleans:
    """Which returns (p,) are neither the map's nor a tracked person's."""
    offset = seen.points[:, None, :] - people.mean[None, :, :2]
    body = np.hypot(offset[..., 0], offset[..., 1]) < people.radius + p.person_margin
    apart = seen.position[:, None, :] - people.mean[None, :, :2]
    person = (np.hypot(apart[..., 0], apart[..., 1]) < p.person_reach).any(axis=1)
    owned = np.append(person, False)[seen.owner]
    free: Booleans = ~(seen.mapped | body.any(axis=1) | owned)
    return free


def _next(layer: ObstacleLayerState, evidence: SignedBytes, occupied: Bytes) -> ObstacleLayerState:
    evidence.flags.writeable = False
    if occupied is layer.obstacles.occupied:
        return replace(layer, evidence=evidence)
    occupied.flags.writeable = False
    known = layer.obstacles
    changed = replace(known, occupied=occupied, version=known.version + 1)
    return ObstacleLayerState(evidence=evidence, obstacles=changed)


# ------------------------------------------------------------------------------------ the window


def _cells_a_side(grid: OccupancyGrid, side: float) -> int:
    return max(round(side / grid.resolution), 1)


def _corner(grid: OccupancyGrid, position: Floats, side: float) -> Integers:
    """The first cell of the window about ``position``; it moves in steps of about 1 m."""
    step = max(round(1.0 / grid.resolution), 1)
    centre = grid.cells(position) // step * step
    corner: Integers = centre - _cells_a_side(grid, side) // 2
    return corner


def _rolled(layer: ObstacleLayerState, corner: Integers) -> ObstacleLayerState:
    """The layer with its window at ``corner``; what leaves it is forgotten."""
    known = layer.obstacles
    if np.array_equal(corner, known.corner):
        return layer
    shift = corner - known.corner
    obstacles = replace(
        known,
        corner=corner,
        occupied=_shifted(known.occupied, shift),
        version=known.version + 1,
    )
    return ObstacleLayerState(evidence=_shifted(layer.evidence, shift), obstacles=obstacles)


def _shifted(cells: _Cells, shift: Integers) -> _Cells:
    out = np.zeros_like(cells)
    rows, cols = cells.shape
    r, c = int(shift[0]), int(shift[1])
    if abs(r) < rows and abs(c) < cols:
        kept = cells[max(r, 0) : rows + min(r, 0), max(c, 0) : cols + min(c, 0)]
        out[max(-r, 0) : rows - max(r, 0), max(-c, 0) : cols - max(c, 0)] = kept
    out.flags.writeable = False
    return out


def _window_from_map(grid: OccupancyGrid, corner: Integers) -> Floats:
    """X_WM, W at the outer corner of the window's first cell, rows along y, columns along x."""
    at = transform(grid.X_MG, corner[::-1] * grid.resolution)
    return inverse(np.array([at[0], at[1], grid.X_MG[2]]))


def _in_cells(X_WM: Floats, points: Floats, grid: OccupancyGrid) -> Floats:
    """(column, row) of map points (..., 2) in the window, as real numbers."""
    return transform(X_WM, points) / grid.resolution


# ----------------------------------------------------------------------------------- the kernels


@njit(cache=True)
def _mark_and_clear(
    evidence: SignedBytes,
    origin: Floats,
    ends: Floats,
    explained: Booleans,
    margin: Floats,
    amounts: Integers,
) -> None:
    """Add and take evidence for the beams from ``origin`` to ``ends``, in cells (column, row).

    A cell is hit or missed at most once in a scan, and a hit outweighs every miss.
    """
    rows, cols = evidence.shape
    hit, miss, most = amounts
    done = np.zeros((rows, cols), dtype=np.uint8)
    for i in range(ends.shape[0]):
        if explained[i]:
            continue
        c, r = math.floor(ends[i, 0]), math.floor(ends[i, 1])
        if 0 <= r < rows and 0 <= c < cols and not done[r, c]:
            done[r, c] = 1
            evidence[r, c] = min(evidence[r, c] + hit, most)
    for i in range(ends.shape[0]):
        _clear(evidence, done, origin, ends[i], margin[i], miss)


@njit(cache=True)
def _clear(
    evidence: SignedBytes, done: Bytes, origin: Floats, end: Floats, margin: float, miss: int
) -> None:
    """Take evidence from the cells that a beam crosses (Amanatides and Woo 1987)."""
    rows, cols = evidence.shape
    dx, dy = end[0] - origin[0], end[1] - origin[1]
    length = math.hypot(dx, dy)
    if length <= margin:
        return
    dx, dy, stop = dx / length, dy / length, length - margin
    c, r = math.floor(origin[0]), math.floor(origin[1])
    step_c, step_r = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    per_c = 1.0 / abs(dx) if dx != 0.0 else np.inf
    per_r = 1.0 / abs(dy) if dy != 0.0 else np.inf
    to_c = ((c + 1 - origin[0]) if dx > 0.0 else (origin[0] - c)) * per_c if dx != 0.0 else np.inf
    to_r = ((r + 1 - origin[1]) if dy > 0.0 else (origin[1] - r)) * per_r if dy != 0.0 else np.inf
    travelled = 0.0
    while travelled < stop:
        if 0 <= r < rows and 0 <= c < cols and not done[r, c]:
            done[r, c] = 1
            evidence[r, c] = max(evidence[r, c] - miss, 0)
        if to_c < to_r:
            travelled, to_c, c = to_c, to_c + per_c, c + step_c
        else:
            travelled, to_r, r = to_r, to_r + per_r, r + step_r


@njit(cache=True)
def _wipe(evidence: SignedBytes, bodies: Floats, resolution: float) -> None:
    """Nothing stands where people (n, 3) of (column, row, radius in m) do."""
    rows, cols = evidence.shape
    for t in range(bodies.shape[0]):
        x, y, radius = bodies[t, 0], bodies[t, 1], bodies[t, 2] / resolution + 1.0
        for r in range(max(int(y - radius), 0), min(int(y + radius) + 1, rows)):
            for c in range(max(int(x - radius), 0), min(int(x + radius) + 1, cols)):
                if math.hypot(c + 0.5 - x, r + 0.5 - y) <= radius:
                    evidence[r, c] = 0


@njit(cache=True)
def _decide(evidence: SignedBytes, occupied: Bytes, occupied_from: int) -> bool:
    """Bring ``occupied`` up to date, in place; whether a cell changed."""
    changed = False
    for r in range(evidence.shape[0]):
        for c in range(evidence.shape[1]):
            e = evidence[r, c]
            if (e >= occupied_from and not occupied[r, c]) or (e <= 0 and occupied[r, c]):
                occupied[r, c] = 1 - occupied[r, c]
                changed = True
    return changed
