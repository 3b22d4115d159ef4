"""Usable returns of a planar scan in the map frame."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.geometry import compose
from cohelm.messages import Scan


@value
class ScanReturns:
    """Usable beams of a scan in the map frame; p returns in beam order, q free beams."""

    origin: Annotated[Floats, Shape("2")]
    """The sensor, m."""
    increment: float
    """Angle between neighbouring beams, rad, ≥ 0."""
    bearing: Annotated[Floats, Shape("p")]
    """Of each return from the sensor, rad, not wrapped, increasing."""
    range: Annotated[Floats, Shape("p")]
    """m."""
    points: Annotated[Floats, Shape("p 2")]
    """m."""
    free_ends: Annotated[Floats, Shape("q 2")]
    """Ends of the beams without a return (+inf), at ``range_max``, m."""


def scan_returns(scan: Scan, X_MR: Floats) -> ScanReturns:
    """Returns of a scan taken at robot pose ``X_MR`` (3,).

    NaN, −inf, ranges ≤ 0 and ranges beyond ``range_max`` are no returns; +inf means that the beam
    is free up to ``range_max`` (REP-117). A scan or a pose that is not finite has no returns.
    """
    given = [*X_MR, *scan.mount, scan.angle_min, scan.angle_increment, scan.range_max]
    if not np.isfinite(given).all():
        none = np.empty(0)
        pairs, zero = none.reshape(0, 2), np.zeros(2)
        return ScanReturns(
            origin=zero, increment=0.0, bearing=none, range=none, points=pairs, free_ends=pairs
        )
    X_MS = compose(X_MR, scan.mount)
    angles = X_MS[2] + scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ranges = scan.ranges
    if scan.angle_increment < 0.0:
        angles, ranges = angles[::-1], ranges[::-1]
    hit = (ranges > 0.0) & (ranges <= scan.range_max)
    free = np.isposinf(ranges)
    origin = X_MS[:2]
    return ScanReturns(
        origin=origin,
        increment=abs(scan.angle_increment),
        bearing=angles[hit],
        range=ranges[hit],
        points=origin + _at(angles[hit], ranges[hit]),
        free_ends=origin + _at(angles[free], np.full(int(free.sum()), scan.range_max)),
    )


def _at(angle: Floats, distance: Floats) -> Floats:
    return np.stack([distance * np.cos(angle), distance * np.sin(angle)], axis=-1)
