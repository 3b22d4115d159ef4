"""Confidence of the chair in what it knows, from the sensor data of a step and the map."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import compose, wrap_angle
from cohelm.maps import DistanceField
from cohelm.messages import ChairConfidence, Observation, Scan

_SECTORS = 44
"""Number of sectors of the directions ahead and beside."""
_BESIDE = math.radians(110.0)
"""Largest angle of a direction beside the chair, rad: what it may drive into."""
_EVERY = 5
"""Every fifth beam is compared with the map."""
_SHARES = np.linspace(0.15, 0.95, 9)
"""Places on a beam that are looked up in the map, as shares of its length."""
_INSIDE = -0.05
"""Depth in a mapped wall from which a beam passes through it, m; less is noise of the pose."""


def update_confidence(
    observation: Observation, walls: DistanceField, last: ChairConfidence | None
) -> ChairConfidence:
    """The chair's confidence now; without a new scan that of the last step.

    Args:
        observation: pose and scans; a chair without lasers is not judged.
        walls: distances to the walls of the static map, m.
        last: confidence of the last step, None at first.
    """
    last = last or ChairConfidence()
    scans = observation.scans
    if not scans:
        return last
    usable = np.concatenate([~np.isnan(scan.ranges) for scan in scans])
    return dataclasses.replace(
        last,
        beams=float(usable.mean()) if len(usable) else 0.0,
        coverage=_coverage(scans),
        map_agreement=1.0 - _through_walls(scans, observation.pose, walls),
    )


def _coverage(scans: tuple[Scan, ...]) -> float:
    """Share of the sectors ahead and beside in which a beam gives a reading."""
    edges = np.linspace(-_BESIDE, _BESIDE, _SECTORS + 1)
    seen = np.zeros(_SECTORS, dtype=bool)
    for scan in scans:
        angles = np.asarray(wrap_angle(scan.mount[2] + _angles(scan)))[~np.isnan(scan.ranges)]
        sector = np.searchsorted(edges, angles[np.abs(angles) < _BESIDE], side="right") - 1
        seen[np.clip(sector, 0, _SECTORS - 1)] = True
    return float(seen.mean())


def _through_walls(scans: tuple[Scan, ...], pose: Floats, walls: DistanceField) -> float:
    """Share of the compared beams that pass through a mapped wall."""
    through: list[Booleans] = []
    for scan in scans:
        X_ML = compose(pose, scan.mount)
        ranges, angles = scan.ranges[::_EVERY], X_ML[2] + _angles(scan)[::_EVERY]
        measured = np.isfinite(ranges)
        along = ranges[measured, None] * _SHARES
        direction = np.stack([np.cos(angles[measured]), np.sin(angles[measured])], axis=-1)
        points = X_ML[:2] + along[..., None] * direction[:, None, :]
        through.append(np.asarray((walls.at(points) < _INSIDE).any(axis=1)))
    found = np.concatenate(through)
    return float(found.mean()) if len(found) else 0.0


def _angles(scan: Scan) -> Floats:
    """Directions of the beams (b,) in the sensor's frame, rad."""
    count = np.arange(len(scan.ranges), dtype=float)
    return np.asarray(scan.angle_min + scan.angle_increment * count, dtype=float)
