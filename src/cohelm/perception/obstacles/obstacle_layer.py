"""Live obstacle layer: obstacles near the chair that are neither in the map nor people.

A rolling window on the map's cells stores an evidence of 0…``max_evidence`` per cell. A return that
neither the map nor a person explains adds evidence, a beam that crosses the cell takes some, and
cells out of view stay. A cell becomes occupied and free at two different levels, so that neither
one noisy return nor one stray beam changes it. Cells of tracked people are cleared; everything that
is not (yet) tracked as a person is an obstacle.

A planar scan is at one height: its beams clear the cells they cross, except objects from a cloud. A
cloud's beams clear the objects they pass through, not those below them (see ``cloud_evidence``).

A beam of a cloud that passes above an object does not clear it. So the layer stores the observed
lower and upper end of each cell's object, and only a beam through that range of heights, on its way
to the floor or to another object, takes evidence away.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
from numba import njit
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
    replace,
    value,
)
from cohelm.config import Model
from cohelm.geometry import inverse, transform
from cohelm.kernels import CACHED, callee
from cohelm.maps import OccupancyGrid
from cohelm.messages import LiveObstacles, People
from cohelm.perception.api import ColumnHeights, Detections
from cohelm.perception.cloud_detection.columns import LAYER, LAYERS
from cohelm.perception.obstacles.cells import (
    EvidenceAmounts,
    beam_buffers,
    clear_people,
    crossed_cells,
    find_unexplained_returns,
    is_empty,
    mark_and_clear,
    update_occupied,
)

FLOOR = 0.06
"""Objects not known to be higher than this are cleared by beams that pass below it, m."""


class SpatialRules(NamedTuple):
    """Parameters of the evidence of clouds."""

    hit: int
    miss: int
    max_evidence: int
    overhang: float
    """Depth below an object's lower end in which a beam still clears it, m."""
    sag_per_cell: float
    """Possible sag of the ground below a straight beam, m per remaining cell."""


class SpatialCells(NamedTuple):
    """Cells of the layer, changed in place."""

    evidence: SignedBytes
    """(rows, cols)."""
    span: Floats32
    """(2, rows, cols) lower and upper end of the object in each cell, m."""
    done: Bytes
    """(rows, cols) 1 for cells that this cloud has already changed."""


class SpatialBeams(NamedTuple):
    """Columns and floor points of a cloud in cells."""

    columns: Floats
    """(p, 3) (column, row), and the last part of the beams to it, which clears nothing."""
    is_obstacle: Booleans
    """(p,) True for obstacles; the others belong to a person or to the map."""
    sensors: Floats
    """(s, 3) (column, row, height in m)."""
    floor: Floats
    """(f, 2) observed floor."""


class _Beam(NamedTuple):
    height: float
    """Height of its start, m."""
    length: float
    """In cells."""
    layers: int
    """Layers in which it ends, bit by bit; 0: on the ground."""


def add_cloud_evidence(
    evidence: SignedBytes,
    span: Floats32,
    heights: ColumnHeights,
    beams: SpatialBeams,
    rules: SpatialRules,
) -> None:
    """Add one cloud to ``evidence`` and ``span``, see :class:`SpatialCells`, in place.

    A hit outweighs every miss.
    """
    cells = SpatialCells(evidence, span, np.zeros(evidence.shape, dtype=np.uint8))
    low_high = np.column_stack([heights.low, heights.high])
    mark_spans(cells, beams.columns[beams.is_obstacle], low_high[beams.is_obstacle], rules)
    layers = heights.first_sensor_layers
    clear_to_columns(cells, beams.sensors[0], beams.columns, layers, rules)
    clear_to_floor(cells, beams.sensors, beams.floor, heights.floor_sensor, rules)


@njit(**CACHED)
def mark_spans(cells: SpatialCells, ends: Floats, heights: Floats, rules: SpatialRules) -> None:
    """Add evidence for unexplained columns, and widen the spans of their cells.

    Args:
        cells: of the layer.
        ends: (p, 2) columns in cells (column, row).
        heights: (p, 2) lower and upper end of each, m.
        rules: the parameters.
    """
    evidence, span, done = cells
    rows, cols = evidence.shape
    for i in range(ends.shape[0]):
        c, r = math.floor(ends[i, 0]), math.floor(ends[i, 1])
        if not (0 <= r < rows and 0 <= c < cols):
            continue
        low, high = np.float32(heights[i, 0]), np.float32(heights[i, 1])
        if evidence[r, c] == 0 or span[1, r, c] == 0.0:
            span[0, r, c], span[1, r, c] = low, high
        else:
            span[0, r, c], span[1, r, c] = min(span[0, r, c], low), max(span[1, r, c], high)
        if not done[r, c]:
            done[r, c] = 1
            evidence[r, c] = min(evidence[r, c] + rules.hit, rules.max_evidence)


@njit(**CACHED)
def clear_to_columns(
    cells: SpatialCells, sensor: Floats, columns: Floats, layers: Integers, rules: SpatialRules
) -> None:
    """Take evidence with the beams from a sensor (3,) to its returns from columns (p, 3).

    layers: (p,), see ``ColumnHeights.first_sensor_layers``.
    """
    crossed, at = beam_buffers(sensor, columns)
    for i in range(columns.shape[0]):
        if layers[i] != 0:
            count = crossed_cells(sensor, columns[i], columns[i, 2], crossed, at)
            length = math.hypot(columns[i, 0] - sensor[0], columns[i, 1] - sensor[1])
            _clear(cells, crossed[:count], at, _Beam(sensor[2], length, layers[i]), rules)


@njit(**CACHED)
def clear_to_floor(
    cells: SpatialCells, sensors: Floats, floor: Floats, floor_sensor: Bytes, rules: SpatialRules
) -> None:
    """Take evidence with the beams from sensors (s, 3) to the floor (f, 2) that each (f,) saw."""
    for s in range(sensors.shape[0]):
        crossed, at = beam_buffers(sensors[s], floor)
        for i in range(floor.shape[0]):
            if floor_sensor[i] == s:
                count = crossed_cells(sensors[s], floor[i], 0.0, crossed, at)
                length = math.hypot(floor[i, 0] - sensors[s, 0], floor[i, 1] - sensors[s, 1])
                _clear(cells, crossed[:count], at, _Beam(sensors[s, 2], length, 0), rules)


@callee()
def _clear(
    cells: SpatialCells, crossed: Integers, at: Floats, beam: _Beam, rules: SpatialRules
) -> None:
    """Take evidence from the crossed cells whose objects the beam passes through.

    at: see ``crossed_cells``.
    """
    evidence, span, done = cells
    for k in range(crossed.shape[0]):
        r, c = crossed[k]
        if not (0 <= r < evidence.shape[0] and 0 <= c < evidence.shape[1]):
            continue
        if evidence[r, c] > 0 and not done[r, c]:
            high = max(span[1, r, c], FLOOR) - rules.sag_per_cell * (beam.length - at[k])
            if _passes(beam, at[k] / beam.length, span[0, r, c] - rules.overhang, high):
                done[r, c] = 1
                evidence[r, c] = max(evidence[r, c] - rules.miss, 0)


@callee()
def _passes(beam: _Beam, share: float, low: float, high: float) -> bool:
    """Check that one of the beams is between two heights after a share of its length."""
    falls = beam.height * (1.0 - share)
    if beam.layers == 0:
        return low <= falls <= high
    rise = max(share, 1e-3) * LAYER
    first = max(math.ceil((low - falls) / rise), 0)
    last = min(math.floor((high - falls) / rise) - 1, LAYERS - 1)
    return last >= first and ((beam.layers >> first) & ((1 << (last - first + 1)) - 1)) != 0


class ObstacleLayerParameters(Model):
    """Parameters of the layer; assumed."""

    side: float = Field(20.0, gt=1.0, le=200.0)
    """Side of the square window, m."""
    hit: int = Field(3, ge=1, le=60)
    """Evidence that returns in a cell add per scan."""
    miss: int = Field(1, ge=1, le=60)
    """Evidence that beams across a cell take per scan."""
    max_evidence: int = Field(9, ge=1, le=127)
    """Upper bound: a removed object is cleared after ``max_evidence / miss`` scans of its cell."""
    occupied_from: int = Field(5, ge=1, le=127)
    """Evidence at which a cell becomes occupied; it becomes free again at 0."""
    end_margin: float = Field(0.1, ge=0.0, le=1.0)
    """The last part of a beam clears nothing, m."""
    end_margin_growth: float = Field(0.01, ge=0.0, le=0.2)
    """Growth of that part with range, m/m."""
    person_margin: float = Field(0.2, ge=0.0, le=1.0)
    """Returns this near a tracked body belong to the person, m."""
    person_reach: float = Field(0.5, ge=0.0, le=2.0)
    """A detection whose centre is this near a tracked person's is that person, m."""
    overhang: float = Field(0.4, ge=0.0, le=2.0)
    """A cloud's beam this far below the lower end of an object still clears it, m: objects on the
    floor are not seen down to it."""
    uneven: float = Field(0.1, ge=0.0, le=0.5)
    """Possible sag of the ground below a beam, m per metre of its remaining length: the foot of a
    ramp."""


DEFAULTS = ObstacleLayerParameters()

Cells = TypeVar("Cells", SignedBytes, Bytes, Floats32)


@value
class ObstacleLayerState:
    """State of the layer."""

    evidence: Annotated[SignedBytes, Shape("rows cols")]
    obstacles: LiveObstacles
    """Output of the layer; the same object as long as nothing changes."""
    span: Annotated[Floats32, Shape("2 rows cols")] | None = None
    """Lower and upper end of the object in each cell from clouds, m; 0: unknown. None before the
    first cloud."""


def update_obstacle_layer(
    layer: ObstacleLayerState | None,
    detections: tuple[Detections, ...],
    people: People,
    grid: OccupancyGrid,
    position: Floats,
    parameters: ObstacleLayerParameters = DEFAULTS,
) -> ObstacleLayerState:
    """Update the layer with some scans; return ``layer`` itself if nothing changes.

    Args:
        layer: the last state, None at first.
        detections: of each new scan; may be empty.
        people: tracked people at present.
        grid: the map, whose cells the window uses.
        position: (2,) position or (3,) pose of the robot, m; the window follows it.
        parameters: of the layer.
    """
    p = parameters
    corner = window_corner(grid, np.asarray(position, dtype=float)[:2], p.side)
    rolled = _empty_layer(grid, corner, p.side) if layer is None else _rolled(layer, corner)
    if not detections:
        return rolled
    unexplained = [_unexplained(found, people, p) for found in detections]
    if not any(each.any() for each in unexplained) and _clears_nothing(rolled, detections):
        return rolled
    evidence, occupied = rolled.evidence.copy(), rolled.obstacles.occupied.copy()
    X_WM = window_from_map(grid, rolled.obstacles.corner)
    span = None if rolled.span is None else rolled.span.copy()
    if span is None and any(found.heights is not None for found in detections):
        span = np.zeros((2, *evidence.shape), dtype=np.float32)
    for found, is_obstacle in zip(detections, unexplained, strict=True):
        if found.heights is not None and span is not None:
            beams = _spatial_beams(found, found.heights, is_obstacle, X_WM, grid, p)
            rules = _spatial_rules(p, grid.resolution)
            add_cloud_evidence(evidence, span, found.heights, beams, rules)
            continue
        before = evidence if span is None else evidence.copy()
        _add_scan(evidence, found, is_obstacle, X_WM, grid, p)
        # Objects from clouds keep their evidence: the scan's beams may pass above or below them.
        if span is not None:
            np.maximum(evidence, before, out=evidence, where=span[1] > 0.0)
    bodies = np.column_stack([_in_cells(X_WM, people.mean[:, :2], grid), people.radius])
    clear_people(evidence, bodies, grid.resolution)
    if not update_occupied(evidence, occupied, p.occupied_from):
        occupied = rolled.obstacles.occupied
    if span is not None:
        np.copyto(span, 0.0, where=evidence <= 0)
        span.flags.writeable = False
    return replace(_next(rolled, evidence, occupied), span=span)


def _empty_layer(grid: OccupancyGrid, corner: Integers, side: float) -> ObstacleLayerState:
    n = cells_a_side(grid, side)
    none = LiveObstacles(corner=corner, occupied=np.zeros((n, n), dtype=np.uint8), version=0)
    return ObstacleLayerState(evidence=np.zeros((n, n), dtype=np.int8), obstacles=none)


def _unexplained(found: Detections, people: People, p: ObstacleLayerParameters) -> Booleans:
    """Mark the returns (m,) that neither the map nor a tracked person explains."""
    return find_unexplained_returns(
        found.points,
        found.mapped,
        found.detection_of_return,
        found.position,
        people.mean,
        people.radius + p.person_margin,
        p.person_reach,
    )


def _clears_nothing(layer: ObstacleLayerState, detections: tuple[Detections, ...]) -> bool:
    """Check that beams have nothing to take: no evidence and no heights."""
    spatial = layer.span is not None or any(found.heights is not None for found in detections)
    return (
        not spatial
        and is_empty(layer.evidence.view(np.uint8))
        and is_empty(layer.obstacles.occupied)
    )


def _add_scan(
    evidence: SignedBytes,
    found: Detections,
    is_obstacle: Booleans,
    X_WM: Floats,
    grid: OccupancyGrid,
    p: ObstacleLayerParameters,
) -> None:
    """Add one scan to ``evidence``, in place."""
    ends = np.concatenate([found.points, found.free_ends])
    margin = p.end_margin + p.end_margin_growth * np.hypot(*(ends - found.origin).T)
    margin[len(found.points) :] = 0.0
    mark_and_clear(
        evidence,
        _in_cells(X_WM, found.origin, grid),
        _in_cells(X_WM, ends, grid),
        np.concatenate([is_obstacle, np.zeros(len(found.free_ends), dtype=np.bool_)]),
        margin / grid.resolution,
        EvidenceAmounts(hit=p.hit, miss=p.miss, most=p.max_evidence),
    )


def _spatial_rules(p: ObstacleLayerParameters, resolution: float) -> SpatialRules:
    return SpatialRules(
        hit=p.hit,
        miss=p.miss,
        max_evidence=p.max_evidence,
        overhang=p.overhang,
        sag_per_cell=p.uneven * resolution,
    )


def _spatial_beams(
    found: Detections,
    heights: ColumnHeights,
    is_obstacle: Booleans,
    X_WM: Floats,
    grid: OccupancyGrid,
    p: ObstacleLayerParameters,
) -> SpatialBeams:
    """Columns and floor of a cloud in cells."""
    margin = p.end_margin + p.end_margin_growth * np.hypot(*(found.points - found.origin).T)
    sensors = _in_cells(X_WM, heights.sensor[:, :2], grid)
    return SpatialBeams(
        columns=np.column_stack([_in_cells(X_WM, found.points, grid), margin / grid.resolution]),
        is_obstacle=is_obstacle,
        sensors=np.column_stack([sensors, heights.sensor[:, 2]]),
        floor=_in_cells(X_WM, heights.floor.astype(float), grid),
    )


def _next(layer: ObstacleLayerState, evidence: SignedBytes, occupied: Bytes) -> ObstacleLayerState:
    evidence.flags.writeable = False
    if occupied is layer.obstacles.occupied:
        return replace(layer, evidence=evidence)
    occupied.flags.writeable = False
    known = layer.obstacles
    changed = replace(known, occupied=occupied, version=known.version + 1)
    return replace(layer, evidence=evidence, obstacles=changed)


def cells_a_side(grid: OccupancyGrid, side: float) -> int:
    """Number of cells along a side, m, of a window."""
    return max(round(side / grid.resolution), 1)


def window_corner(grid: OccupancyGrid, position: Floats, side: float) -> Integers:
    """First cell of the window about ``position``; it moves in steps of about 1 m."""
    step = max(round(1.0 / grid.resolution), 1)
    centre = grid.cells(position) // step * step
    corner: Integers = centre - cells_a_side(grid, side) // 2
    return corner


def _rolled(layer: ObstacleLayerState, corner: Integers) -> ObstacleLayerState:
    """Move the window to ``corner``; cells that leave it are dropped."""
    known = layer.obstacles
    if corner.tolist() == known.corner.tolist():
        return layer
    shift = corner - known.corner
    obstacles = replace(
        known,
        corner=corner,
        occupied=shifted(known.occupied, shift),
        version=known.version + 1,
    )
    span = layer.span
    return ObstacleLayerState(
        evidence=shifted(layer.evidence, shift),
        obstacles=obstacles,
        span=None if span is None else np.stack([shifted(each, shift) for each in span]),
    )


def shifted(cells: Cells, shift: Integers) -> Cells:
    """Cells of a window that moves by (rows, columns); new ones are 0."""
    out = np.zeros_like(cells)
    rows, cols = cells.shape
    r, c = int(shift[0]), int(shift[1])
    if abs(r) < rows and abs(c) < cols:
        kept = cells[max(r, 0) : rows + min(r, 0), max(c, 0) : cols + min(c, 0)]
        out[max(-r, 0) : rows - max(r, 0), max(-c, 0) : cols - max(c, 0)] = kept
    out.flags.writeable = False
    return out


def window_from_map(grid: OccupancyGrid, corner: Integers) -> Floats:
    """X_WM: W is at the outer corner of the window's first cell, rows along y, columns along x."""
    at = transform(grid.X_MG, corner[::-1] * grid.resolution)
    return inverse(np.array([at[0], at[1], grid.X_MG[2]]))


def _in_cells(X_WM: Floats, points: Floats, grid: OccupancyGrid) -> Floats:
    """(column, row) of map points (..., 2) in the window, as real numbers."""
    return transform(X_WM, points) / grid.resolution
