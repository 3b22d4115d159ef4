"""Usable returns of a planar scan in the map frame."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Shape, sealed, value
from cohelm.geometry import compose
from cohelm.kernels import CACHED
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
    beams = float(scan.angle_min), float(scan.angle_increment), float(scan.range_max)
    given = [*X_MR.tolist(), *scan.mount.tolist(), *beams]
    if not all(map(math.isfinite, given)):
        none = np.empty(0)
        pairs, zero = none.reshape(0, 2), np.zeros(2)
        return ScanReturns(
            origin=zero, increment=0.0, bearing=none, range=none, points=pairs, free_ends=pairs
        )
    X_MS = compose(X_MR, scan.mount)
    found = sealed(_ends(scan.ranges, X_MS, *beams))
    return ScanReturns(origin=X_MS[:2], increment=abs(beams[1]), **found._asdict())


class _Ends(NamedTuple):
    """Columns of ``ScanReturns``."""

    bearing: Floats
    range: Floats
    points: Floats
    free_ends: Floats


@njit(**CACHED)
def _ends(
    ranges: Floats, X_MS: Floats, angle_min: float, increment: float, range_max: float
) -> _Ends:
    """Ends of the beams of a scan, (b,) ranges in m, from the sensor's pose (3,)."""
    b, hits, free = len(ranges), 0, 0
    out = _Ends(np.empty(b), np.empty(b), np.empty((b, 2)), np.empty((b, 2)))
    for i in range(b):
        # Counter-clockwise, whatever the direction of the scan.
        k = i if increment >= 0.0 else b - 1 - i
        angle, r = X_MS[2] + angle_min + increment * k, ranges[k]
        if 0.0 < r <= range_max:
            out.bearing[hits], out.range[hits] = angle, r
            out.points[hits, 0] = X_MS[0] + r * math.cos(angle)
            out.points[hits, 1] = X_MS[1] + r * math.sin(angle)
            hits += 1
        elif r == np.inf:
            out.free_ends[free, 0] = X_MS[0] + range_max * math.cos(angle)
            out.free_ends[free, 1] = X_MS[1] + range_max * math.sin(angle)
            free += 1
    return _Ends(out.bearing[:hits], out.range[:hits], out.points[:hits], out.free_ends[:free])
