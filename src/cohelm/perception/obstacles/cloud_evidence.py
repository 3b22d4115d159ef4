"""Evidence of a cloud for the cells of the obstacle layer, with the heights of objects.

A beam that passes above an object does not clear it. So the layer stores the observed lower and
upper end of each cell's object, and only a beam through that range of heights, on its way to the
floor or to another object, takes evidence away.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Bytes, Floats, Floats32, Integers, SignedBytes
from cohelm.kernels import CACHED
from cohelm.perception.api import ColumnHeights
from cohelm.perception.cloud_detection.columns import LAYER, LAYERS
from cohelm.perception.obstacles.cells import beam_buffers, crossed_cells

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


@njit(**CACHED)
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


@njit(**CACHED)
def _passes(beam: _Beam, share: float, low: float, high: float) -> bool:
    """Check that one of the beams is between two heights after a share of its length."""
    falls = beam.height * (1.0 - share)
    if beam.layers == 0:
        return low <= falls <= high
    rise = max(share, 1e-3) * LAYER
    first = max(math.ceil((low - falls) / rise), 0)
    last = min(math.floor((high - falls) / rise) - 1, LAYERS - 1)
    return last >= first and ((beam.layers >> first) & ((1 << (last - first + 1)) - 1)) != 0
