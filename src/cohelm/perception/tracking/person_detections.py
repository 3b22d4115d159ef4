"""Possible people of one scan, as compiled code of the tracker takes them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats, Integers, read_only
from cohelm.kernels import callee
from cohelm.perception.api import Detections

_NO_SHAPE, _FULL_SHAPE, _MIN_SHAPE_WEIGHT = 3.0, 8.0, 0.1
"""Numbers of returns that show no shape, and the whole shape; and the least weight of a shape."""
_MIN_PROBABILITY, _MAX_PROBABILITY = 0.01, 0.99
"""Bounds of a detection's confidence: they keep the log-odds finite."""


class ScanTable(NamedTuple):
    """The part of ``Detections`` that the tracker uses, for compiled code."""

    time: float
    origin: Floats
    points: Floats
    free_ends: Floats
    detection_of_return: Integers
    position: Floats
    radius: Floats
    deviation: Floats
    confidence: Floats
    arrival_log_odds: Floats
    """(d,), or empty without change detection."""
    has_changes: bool
    same_view: bool


_UNKNOWN: Floats = read_only(np.empty(0))


def scan_table(found: Detections) -> ScanTable:
    """Columns of ``found``."""
    arrival = found.arrival_log_odds
    return ScanTable(
        float(found.time),
        found.origin,
        found.points,
        found.free_ends,
        found.detection_of_return,
        found.position,
        found.radius,
        found.deviation,
        found.confidence,
        _UNKNOWN if arrival is None else arrival,
        arrival is not None,
        found.same_view,
    )


class PersonDetections(NamedTuple):
    """Possible people of one scan, d of them, ordered by distance from the sensor.

    The order makes the result independent of the detector's order.
    """

    position: Floats
    """(d, 2) m."""
    radius: Floats
    """(d,) m."""
    deviation: Floats
    """(d,) m."""
    log_odds: Floats
    """(d,) ln(p / (1 − p)) of a person from the shape."""
    arrival_log_odds: Floats
    """(d,) ln(p / (1 − p)) of having arrived at its place; 0 where unknown."""
    shape_weight: Floats
    """(d,) weight as an observation of the shape, 0…1."""


@callee()
def person_detections(scan: ScanTable) -> PersonDetections:
    """Sort the people of a scan by distance, then by x and y; probabilities are at most 99 %."""
    d = len(scan.radius)
    order, distance, returns = np.empty(d, dtype=np.int64), np.empty(d), np.zeros(d)
    for j in range(d):
        x, y = scan.position[j, 0] - scan.origin[0], scan.position[j, 1] - scan.origin[1]
        distance[j] = math.hypot(x, y)
        # Insertion; of equals, the earlier one stays first.
        k = j
        while k > 0 and _is_nearer(scan, distance, j, order[k - 1]):
            order[k] = order[k - 1]
            k -= 1
        order[k] = j
    for j in scan.detection_of_return:
        if j >= 0:
            returns[j] += 1.0
    out = PersonDetections(
        np.empty((d, 2)),
        np.empty(d),
        np.empty(d),
        np.empty(d),
        np.zeros(d),
        np.ones(d),
    )
    for k in range(d):
        j = order[k]
        p = min(max(scan.confidence[j], _MIN_PROBABILITY), _MAX_PROBABILITY)
        out.position[k] = scan.position[j]
        out.radius[k], out.deviation[k] = scan.radius[j], scan.deviation[j]
        out.log_odds[k] = math.log(p / (1.0 - p))
        # With change detection, few returns show no shape.
        if scan.has_changes:
            out.arrival_log_odds[k] = scan.arrival_log_odds[j]
            weight = (returns[j] - _NO_SHAPE) / (_FULL_SHAPE - _NO_SHAPE)
            out.shape_weight[k] = min(max(weight, _MIN_SHAPE_WEIGHT), 1.0)
    return out


@callee()
def _is_nearer(scan: ScanTable, distance: Floats, j: int, k: int) -> bool:
    """Check that detection j comes before k."""
    if distance[j] != distance[k]:
        return bool(distance[j] < distance[k])
    # Both offsets from the sensor, as the distances.
    for axis in range(2):
        one = scan.position[j, axis] - scan.origin[axis]
        other = scan.position[k, axis] - scan.origin[axis]
        if one != other:
            return bool(one < other)
    return False
