"""Motion of the chair, and its track compared with the route and the rider's wishes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.episode.ride import GOAL_RADIUS, Outcome, Ride
from cohelm.geometry import arc_length, nearest_on_polyline, resample, wrap_angle

SHORT_OF_GOAL = 0.3
"""Distance from the goal at which the shorter of the two path lengths ends, m."""
SPACING = 0.05
"""Distance between the points at which two polylines are compared, m."""


class PathError(NamedTuple):
    """Distance between two polylines, m."""

    mean: float
    hausdorff: float


def arrival(ride: Ride) -> int | None:
    """Index of the first tick within 0.2 m of the goal; None: never."""
    there = np.flatnonzero(distance_to_goal(ride) <= GOAL_RADIUS)
    return int(there[0]) if len(there) else None


def distance_to_goal(ride: Ride) -> Floats:
    """Distance from the goal, (k,), m."""
    away = ride.pose[:, :2] - ride.goal
    return np.hypot(away[:, 0], away[:, 1])


def time(ride: Ride) -> float:
    """Time to the first arrival within 0.2 m of the goal, s; NaN without one."""
    at = arrival(ride)
    return float("nan") if at is None else float(ride.time[at] - ride.time[0])


def path_length(ride: Ride) -> float:
    """Σ‖Δp‖ to the first arrival plus the remaining distance to the goal point, m.

    Without an arrival: the length of the whole track.
    """
    at = arrival(ride)
    driven = arc_length(ride.pose[:, :2])
    if at is None:
        return float(driven[-1])
    return float(driven[at] + distance_to_goal(ride)[at])


def path_length_short(ride: Ride) -> float:
    """Σ‖Δp‖ until the chair is within 0.3 m of the goal, m; else the length of the whole track."""
    there = np.flatnonzero(distance_to_goal(ride) <= SHORT_OF_GOAL)
    end = int(there[0]) if len(there) else len(ride.pose) - 1
    return float(arc_length(ride.pose[: end + 1, :2])[-1])


def underway(ride: Ride) -> Floats:
    """Twists until the first arrival, (j, 3); all without one."""
    at = arrival(ride)
    return ride.twist if at is None else ride.twist[: at + 1]


def heading_change(ride: Ride) -> float:
    """Σ|wrap(Δθ)|, rad."""
    return float(np.abs(wrap_angle(np.diff(ride.pose[:, 2]))).sum())


def acceleration(ride: Ride) -> Floats:
    """Δv/Δt between ticks, (k−1,), m/s²."""
    return np.diff(ride.twist[:, 0]) / ride.step


def jerk(ride: Ride) -> Floats:
    """Δ²v/Δt² between ticks, (k−2,), m/s³."""
    return np.diff(ride.twist[:, 0], n=2) / ride.step**2


def rms(values: Floats) -> float:
    """Root mean square; 0 of no values."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def stalled_time(ride: Ride) -> float:
    """Time standing farther than 0.2 m from the goal, s."""
    stalled = ride.standing & (distance_to_goal(ride) > GOAL_RADIUS)
    return float(stalled.sum() * ride.step)


def path_error(path: Floats, desired: Floats) -> PathError:
    """Distance of a polyline (k, 2) from a desired one (j, 2), m.

    The mean runs over the arc length of the path, to the nearest point of the desired path. The
    Hausdorff distance is the larger of both directed ones.
    """
    there = _distances(resample(path, SPACING), desired)
    back = _distances(resample(desired, SPACING), path)
    weight = np.ones(len(there))
    weight[[0, -1]] = 0.5  # trapezoidal rule
    mean = float(np.average(there, weights=weight))
    return PathError(mean, float(max(there.max(), back.max())))


def ride_error(ride: Ride) -> float:
    """Mean distance of the track from the first route, m; NaN without a route."""
    return _against_route(ride).mean


def ride_hausdorff(ride: Ride) -> float:
    """Hausdorff distance between the track and the first route, m; NaN without a route."""
    return _against_route(ride).hausdorff


def preference_distance(ride: Ride) -> float:
    """Distance of the track from the via point that it missed most, m; NaN without via points."""
    if not len(ride.prefer):
        return float("nan")
    return float(_distances(ride.prefer, ride.pose[:, :2]).max())


def spl(ride: Ride) -> float:
    """Success · L*/max(L, L*), with L* of the route without wishes (Anderson et al. 2018)."""
    if ride.outcome is not Outcome.REACHED or ride.path is None:
        return 0.0
    shortest = float(arc_length(ride.path.without_wishes)[-1])
    longest = max(path_length(ride), shortest)
    return shortest / longest if longest > 0.0 else 1.0


def _against_route(ride: Ride) -> PathError:
    if ride.path is None:
        return PathError(float("nan"), float("nan"))
    return path_error(ride.pose[:, :2], ride.path.points)


def _distances(points: Floats, polyline: Floats) -> Floats:
    line = np.ascontiguousarray(polyline)
    return np.array([nearest_on_polyline(line, x, y)[1] for x, y in points])
