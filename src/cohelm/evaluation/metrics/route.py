"""How the driven track compares with the route and with what the rider wanted."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.metrics.motion import path_length
from cohelm.evaluation.ride import Outcome, Ride
from cohelm.geometry import arc_length, nearest_on_polyline, resample

SPACING = 0.05
"""Between the points at which two polylines are compared, m."""


def path_error(path: Floats, desired: Floats) -> tuple[float, float]:
    """(mean, Hausdorff) distance of a polyline (k, 2) from a desired one (j, 2), m.

    The mean runs over the path's arc length, to the nearest point of the desired path; the
    Hausdorff distance is the larger of both directed ones.
    """
    there = _distances(resample(path, SPACING), desired)
    back = _distances(resample(desired, SPACING), path)
    weight = np.ones(len(there))
    weight[[0, -1]] = 0.5  # trapezoids: the ends stand for half a piece
    return float(np.average(there, weights=weight)), float(max(there.max(), back.max()))


def ride_error(ride: Ride) -> float:
    """Mean distance of the driven track from the first route, m; NaN without a route."""
    return _against_route(ride)[0]


def ride_hausdorff(ride: Ride) -> float:
    """Hausdorff distance between the driven track and the first route, m; NaN without a route."""
    return _against_route(ride)[1]


def preference_distance(ride: Ride) -> float:
    """The worst of the least distances of the driven track to the wished points, m; NaN: none."""
    if not len(ride.prefer):
        return float("nan")
    return float(_distances(ride.prefer, ride.pose[:, :2]).max())


def spl(ride: Ride) -> float:
    """Success · L*/max(L, L*), L* being the route without wishes (Anderson et al. 2018)."""
    if ride.outcome is not Outcome.REACHED or ride.path is None:
        return 0.0
    shortest = float(arc_length(ride.path.without_wishes)[-1])
    longest = max(path_length(ride), shortest)
    return shortest / longest if longest > 0.0 else 1.0


def _against_route(ride: Ride) -> tuple[float, float]:
    if ride.path is None:
        return float("nan"), float("nan")
    return path_error(ride.pose[:, :2], ride.path.points)


def _distances(points: Floats, polyline: Floats) -> Floats:
    line = np.ascontiguousarray(polyline)
    return np.array([nearest_on_polyline(line, x, y)[1] for x, y in points])
