"""What the beams of a 3-D sensor say of cells: from what height to what something stands there.

A beam that passes over a thing does not deny it. So the layer remembers how high each cell's thing
was seen to begin and end, and only a beam that goes through that much of it, on its way to the
floor or to something else, takes evidence from it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Bytes, Floats, Floats32, Integers, SignedBytes
from cohelm.perception.api import Heights
from cohelm.perception.columns import LAYER, LAYERS
from cohelm.perception.obstacle_cells import crossed, room_for

FLOOR = 0.06
"""What is not known to be higher than this is denied by beams that pass lower, m."""


@njit(cache=True)
def floor_places(
    points: Floats, ground: Booleans, parts: Integers, side: float
) -> tuple[Floats32, Bytes]:
    """Where each sensor saw the floor: one place for each square, (f, 2), and which sensor, (f,).

    Args:
        points: (p, 3) from the first sensor, m; sensor after sensor.
        ground: (p,) which are floor.
        parts: (s + 1,) where the returns of each sensor begin, and the last end.
        side: of a square, m.
    """
    reach = 0.0
    for i in range(points.shape[0]):
        if ground[i]:
            reach = max(reach, abs(points[i, 0]), abs(points[i, 1]))
    cells = int(2.0 * reach / side) + 2
    met = np.full(cells * cells, -1, dtype=np.int16)
    where, who = (
        np.empty((points.shape[0], 2), dtype=np.float32),
        np.empty(points.shape[0], np.uint8),
    )
    count = 0
    for s in range(parts.size - 1):
        for i in range(parts[s], parts[s + 1]):
            if not ground[i]:
                continue
            row, col = int((points[i, 1] + reach) / side), int((points[i, 0] + reach) / side)
            if met[row * cells + col] != s:
                met[row * cells + col] = s
                where[count, 0], where[count, 1], who[count] = points[i, 0], points[i, 1], s
                count += 1
    return where[:count].copy(), who[:count].copy()


def look_in_space(
    evidence: SignedBytes,
    span: Floats32,
    heights: Heights,
    *,
    columns: Floats,
    free: Booleans,
    sensors: Floats,
    floor: Floats,
    rules: Floats,
) -> None:
    """Put one cloud into ``evidence`` and ``span``, in place; a hit outweighs every miss.

    Args:
        evidence: (rows, cols).
        span: (2, rows, cols), see ``mark_spans``.
        heights: of the cloud.
        columns: (p, 3) in cells: (column, row) of each, and the last part of the beams to it, which
            clears nothing.
        free: (p,) which of them stand in the way; the others are a person's, or in the map.
        sensors: (s, 3) (column, row, height in m).
        floor: (f, 2) where the floor was seen, in cells.
        rules: see ``mark_spans``.
    """
    done = np.zeros(evidence.shape, dtype=np.uint8)
    low_high = np.column_stack([heights.low, heights.high])
    mark_spans(evidence, span, done, columns[free], low_high[free], rules)
    clear_to_columns(evidence, span, done, sensors[0], columns, heights.layers, rules)
    clear_to_floor(evidence, span, done, sensors, floor, heights.seen_by, rules)


@njit(cache=True)
def mark_spans(
    evidence: SignedBytes,
    span: Floats32,
    done: Bytes,
    ends: Floats,
    heights: Floats,
    rules: Floats,
) -> None:
    """Add evidence for columns that nothing explains, and widen what is known of their heights.

    Args:
        evidence: (rows, cols), in place; so are the next two.
        span: (2, rows, cols) from what height to what something was seen in each cell, m.
        done: which cells are settled in this cloud.
        ends: (p, 2) columns in cells (column, row).
        heights: (p, 2) where each begins and ends, m.
        rules: evidence of a hit, of a miss, and at most; how far below a thing a beam still denies
            it, m; by how much the ground may lie lower than between a beam's ends, for each cell
            of way left, m.
    """
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
            evidence[r, c] = min(evidence[r, c] + int(rules[0]), int(rules[2]))


@njit(cache=True)
def clear_to_columns(  # noqa: PLR0917  # a kernel takes arrays and numbers
    evidence: SignedBytes,
    span: Floats32,
    done: Bytes,
    sensor: Floats,
    columns: Floats,
    layers: Integers,
    rules: Floats,
) -> None:
    """Take evidence with the beams from a sensor (3,) to what it saw of columns (p, 3).

    Args:
        evidence, span, done, rules: see ``mark_spans``.
        sensor: (column, row, height in m).
        columns: see ``look_in_space``.
        layers: (p,), see ``Heights``.
    """
    cells, at = room_for(sensor, columns)
    for i in range(columns.shape[0]):
        if layers[i] != 0:
            count = crossed(sensor, columns[i], columns[i, 2], cells, at)
            length = math.hypot(columns[i, 0] - sensor[0], columns[i, 1] - sensor[1])
            beam = (sensor[2], length, layers[i])
            _deny(evidence, span, done, cells[:count], at, beam, rules)


@njit(cache=True)
def clear_to_floor(  # noqa: PLR0917  # a kernel takes arrays and numbers
    evidence: SignedBytes,
    span: Floats32,
    done: Bytes,
    sensors: Floats,
    floor: Floats,
    seen_by: Bytes,
    rules: Floats,
) -> None:
    """Take evidence with the beams from sensors (s, 3) to the floor (f, 2).

    Args:
        evidence, span, done, rules: see ``mark_spans``.
        sensors: (column, row, height in m).
        floor: (column, row).
        seen_by: (f,) the sensor.
    """
    for s in range(sensors.shape[0]):
        cells, at = room_for(sensors[s], floor)
        for i in range(floor.shape[0]):
            if seen_by[i] == s:
                count = crossed(sensors[s], floor[i], 0.0, cells, at)
                length = math.hypot(floor[i, 0] - sensors[s, 0], floor[i, 1] - sensors[s, 1])
                _deny(evidence, span, done, cells[:count], at, (sensors[s, 2], length, 0), rules)


@njit(cache=True)
def _deny(  # noqa: PLR0917  # a kernel takes arrays and numbers
    evidence: SignedBytes,
    span: Floats32,
    done: Bytes,
    cells: Integers,
    at: Floats,
    beam: tuple[float, float, int],
    rules: Floats,
) -> None:
    """Take evidence from those of a beam's cells whose things it goes through.

    Args:
        evidence, span, done, rules: see ``mark_spans``.
        cells: that it crosses.
        at: see ``crossed``.
        beam: (height at which it begins, m; length in cells; in which layers it ends, 0: on the
            ground).
    """
    above, length, layers = beam
    for k in range(cells.shape[0]):
        r, c = cells[k]
        if not (0 <= r < evidence.shape[0] and 0 <= c < evidence.shape[1]):
            continue
        if evidence[r, c] > 0 and not done[r, c]:
            high = max(span[1, r, c], FLOOR) - rules[4] * (length - at[k])
            if _passes(above, at[k] / length, layers, span[0, r, c] - rules[3], high):
                done[r, c] = 1
                evidence[r, c] = max(evidence[r, c] - int(rules[1]), 0)


@njit(cache=True)
def _passes(above: float, share: float, layers: int, low: float, high: float) -> bool:
    """Whether one of some beams is between two heights when it has gone that share of its way."""
    falls = above * (1.0 - share)
    if layers == 0:
        return low <= falls <= high
    rise = max(share, 1e-3) * LAYER
    first = max(math.ceil((low - falls) / rise), 0)
    last = min(math.floor((high - falls) / rise) - 1, LAYERS - 1)
    return last >= first and ((layers >> first) & ((1 << (last - first + 1)) - 1)) != 0
