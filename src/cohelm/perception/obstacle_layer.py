"""The live obstacle layer: what stands about the chair that is neither in the map nor a person.

A rolling window on the map's cells holds for each an evidence of 0…``most``. A return that neither
the map nor a person explains adds to its cell's, a beam that crosses a cell takes from it, and what
is out of view is kept. A cell becomes occupied and free at two different levels, so that neither
one noisy return nor one stray beam flips it. Tracked people are wiped out of it, cells that they
covered before they were recognised included; what is not (yet) tracked as a person is an obstacle.

A planar scan is at one height: its beams clear what they cross, but for what a cloud saw. A cloud's
beams clear what they go through, not what they pass over (see ``cloud_clearing``).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from pydantic import Field

from cohelm.arrays import (
    Annotated,
    Booleans,
    Bytes,
    Floats,
    Floats32,
    Integers,
    Shape,
    SignedBytes,
    value,
)
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import LiveObstacles, People
from cohelm.perception.api import Detections, Heights
from cohelm.perception.cloud_clearing import look_in_space
from cohelm.perception.obstacle_cells import decide, is_empty, mark_and_clear, unexplained, wipe


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
    overhang: float = Field(0.4, ge=0.0, le=2.0)
    """A cloud's beam this far below what was seen of a thing still denies it, m: what stands on the
    floor was not seen down to it."""
    uneven: float = Field(0.1, ge=0.0, le=0.5)
    """By how much the ground may lie lower than a straight line between a beam's ends, m for each
    metre that is left of it: where a ramp begins."""


DEFAULTS = ObstacleLayerParameters()

_Cells = TypeVar("_Cells", SignedBytes, Bytes, Floats32)


@value
class ObstacleLayerState:
    """The layer's memory."""

    evidence: Annotated[SignedBytes, Shape("rows cols")]
    obstacles: LiveObstacles
    """What the rest of the system reads; the same object as long as nothing changes."""
    span: Annotated[Floats32, Shape("2 rows cols")] | None = None
    """From what height to what clouds saw something in each cell, m; 0: not known. None: there was
    no cloud yet."""


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
    free = [_unexplained(seen, people, p) for seen in detections]
    if not any(each.any() for each in free) and _says_nothing(rolled, detections):
        return rolled
    evidence, occupied = rolled.evidence.copy(), rolled.obstacles.occupied.copy()
    X_WM = _window_from_map(grid, rolled.obstacles.corner)
    span = None if rolled.span is None else rolled.span.copy()
    if span is None and any(seen.heights is not None for seen in detections):
        span = np.zeros((2, *evidence.shape), dtype=np.float32)
    bodies = np.column_stack([_in_cells(X_WM, people.mean[:, :2], grid), people.radius])
    for seen, new in zip(detections, free, strict=True):
        if seen.heights is not None and span is not None:
            _look_in_space(evidence, span, seen, seen.heights, free=new, X_WM=X_WM, grid=grid, p=p)
            continue
        before = evidence if span is None else evidence.copy()
        _look(evidence, seen, ~new, X_WM, grid, p)
        if span is not None:
            np.maximum(evidence, before, out=evidence, where=span[1] > 0.0)
    wipe(evidence, bodies, grid.resolution)
    if not decide(evidence, occupied, p.occupied_from):
        occupied = rolled.obstacles.occupied
    if span is not None:
        span[:, evidence <= 0] = 0.0
        span.flags.writeable = False
    return replace(_next(rolled, evidence, occupied), span=span)


def _says_nothing(layer: ObstacleLayerState, detections: tuple[Detections, ...]) -> bool:
    """Whether beams have nothing to take: no scan, or no evidence and nothing known of heights."""
    if not detections:
        return True
    spatial = layer.span is not None or any(seen.heights is not None for seen in detections)
    return not spatial and is_empty(layer.evidence) and is_empty(layer.obstacles.occupied)


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
    mark_and_clear(
        evidence,
        _in_cells(X_WM, seen.origin, grid),
        _in_cells(X_WM, ends, grid),
        np.concatenate([explained, np.ones(len(seen.through), dtype=np.bool_)]),
        margin / grid.resolution,
        np.array([p.hit, p.miss, p.most]),
    )


def _look_in_space(
    evidence: SignedBytes,
    span: Floats32,
    seen: Detections,
    heights: Heights,
    *,
    free: Booleans,
    X_WM: Floats,
    grid: OccupancyGrid,
    p: ObstacleLayerParameters,
) -> None:
    """Put one cloud into ``evidence`` and ``span``, in place."""
    margin = p.end_margin + p.end_margin_growth * np.hypot(*(seen.points - seen.origin).T)
    look_in_space(
        evidence,
        span,
        heights,
        columns=np.column_stack([_in_cells(X_WM, seen.points, grid), margin / grid.resolution]),
        free=free,
        sensors=np.column_stack(
            [_in_cells(X_WM, heights.sensor[:, :2], grid), heights.sensor[:, 2]]
        ),
        floor=_in_cells(X_WM, heights.floor.astype(float), grid),
        rules=np.array([p.hit, p.miss, p.most, p.overhang, p.uneven * grid.resolution]),
    )


def _unexplained(seen: Detections, people: People, p: ObstacleLayerParameters) -> Booleans:
    """Which returns (p,) are neither the map's nor a tracked person's."""
    body = people.radius + p.person_margin
    free: Booleans = unexplained(
        seen.points, seen.mapped, seen.owner, seen.position, people.mean, body, p.person_reach
    )
    return free


def _next(layer: ObstacleLayerState, evidence: SignedBytes, occupied: Bytes) -> ObstacleLayerState:
    evidence.flags.writeable = False
    if occupied is layer.obstacles.occupied:
        return replace(layer, evidence=evidence)
    occupied.flags.writeable = False
    known = layer.obstacles
    changed = replace(known, occupied=occupied, version=known.version + 1)
    return replace(layer, evidence=evidence, obstacles=changed)


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
    span = layer.span
    return ObstacleLayerState(
        evidence=_shifted(layer.evidence, shift),
        obstacles=obstacles,
        span=None if span is None else np.stack([_shifted(each, shift) for each in span]),
    )


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
