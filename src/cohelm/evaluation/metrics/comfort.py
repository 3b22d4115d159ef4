"""Stops, braking and felt jerk: how calmly the chair moves."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.episode.ride import GOAL_RADIUS, Ride
from cohelm.evaluation.episode.ride_log import ONE_STOP
from cohelm.evaluation.metrics.motion import acceleration, distance_to_goal

SEAT = 0.1
"""Time constant of the low-pass that passes the acceleration to the seat, s (assumed)."""
SHORT_STOP = 0.3
"""Duration below which a stop is short, s: felt as a jolt, and no traffic needs it."""
HARD = 0.8
"""Deceleration above which braking is hard, m/s²."""
BRAKING = 0.05
"""Deceleration above which the chair brakes, m/s²."""
_ROUNDING = 1e-6
"""Tolerance of a deceleration that equals a limit, m/s²."""


def felt_jerk(ride: Ride) -> Floats:
    """Jerk at the seat, (k−1,), m/s³.

    The acceleration Δv/Δt passes a first-order low-pass with the time constant 0.1 s, exact for an
    acceleration that is constant during a tick: y ← y + (1 − exp(−Δt/τ)) (a − y). The jerk is
    Δy/Δt. Before the ride the acceleration is 0.
    """
    gain = -math.expm1(-ride.step / SEAT)
    felt = np.zeros(len(ride.time))
    for k, a in enumerate(acceleration(ride)):
        felt[k + 1] = felt[k] + gain * (a - felt[k])
    return np.diff(felt) / ride.step


def felt_jerk_p99(ride: Ride) -> float:
    """99th percentile of the absolute jerk at the seat, m/s³; 0 of a ride of one tick."""
    jerk = np.abs(felt_jerk(ride))
    return float(np.percentile(jerk, 99.0)) if len(jerk) else 0.0


def deceleration(ride: Ride) -> Floats:
    """−Δ|v|/Δt between ticks, (k−1,), m/s²; negative while the chair gains speed."""
    slower: Floats = -np.diff(np.abs(ride.twist[:, 0])) / ride.step
    return slower


def braking_time(ride: Ride) -> float:
    """Time with a deceleration above 0.05 m/s², s."""
    return float((deceleration(ride) > BRAKING).sum() * ride.step)


def hard_braking(ride: Ride) -> float:
    """Share of the ride with a deceleration above 0.8 m/s²; 0 of a ride of one tick."""
    slower = deceleration(ride)
    return float((slower > HARD + _ROUNDING).mean()) if len(slower) else 0.0


def gentle_braking(ride: Ride) -> float:
    """Share of the braking time with a deceleration of at most 0.8 m/s²; NaN without braking."""
    slower = deceleration(ride)
    slower = slower[slower > BRAKING]
    return float((slower <= HARD + _ROUNDING).mean()) if len(slower) else math.nan


def stop_rate(ride: Ride) -> float:
    """Stops per minute of the ride; NaN of a ride of one tick."""
    minutes = (ride.time[-1] - ride.time[0]) / 60.0
    return len(stop_intervals(ride)) / minutes if minutes > 0.0 else math.nan


def short_stops(ride: Ride) -> float:
    """Number of stops that last less than 0.3 s."""
    duration = np.diff(stop_intervals(ride), axis=1)
    return float((duration < SHORT_STOP - _ROUNDING).sum())


def stop_intervals(ride: Ride) -> Floats:
    """First and last time of each stop, (m, 2), s.

    The chair stops where it comes to a stand, or stands or brakes for a reason (``Ride.stops``).
    Stops less than a second apart are one. A ride begins at a stand and ends at the goal: stops
    before the chair first moves, and those that begin within 0.2 m of the goal, do not count. Nor
    does a stand of up to a second at which the chair changes between driving forward and backward.
    """
    moving = np.flatnonzero(~ride.standing)
    if not len(moving):
        return np.empty((0, 2))
    reasons = [(stop.time, stop.time + stop.duration) for stop in ride.stops]
    away = distance_to_goal(ride) > GOAL_RADIUS
    begun = ride.time >= ride.time[moving[0]]
    stops: list[tuple[float, float]] = []
    stands = [run for run in _runs(ride.time, ride.standing & away) if not _turns(ride, *run)]
    for begin, end in sorted([*reasons, *stands]):
        # A reason is logged with the time of a tick.
        tick = min(int(np.searchsorted(ride.time, begin - _ROUNDING)), len(ride.time) - 1)
        if not (away[tick] and begun[tick]):
            continue
        if stops and begin - stops[-1][1] <= ONE_STOP:
            stops[-1] = stops[-1][0], max(end, stops[-1][1])
        else:
            stops.append((begin, end))
    return np.array(stops).reshape(-1, 2)


def _turns(ride: Ride, begin: float, end: float) -> bool:
    """Check whether the chair changes between forward and backward during a short stand."""
    first, last = np.searchsorted(ride.time, (begin - _ROUNDING, end - _ROUNDING))
    if end - begin > ONE_STOP or first == 0 or last + 1 >= len(ride.time):
        return False
    return bool(ride.twist[first - 1, 0] * ride.twist[last + 1, 0] < 0.0)


def _runs(time: Floats, mask: Booleans) -> list[tuple[float, float]]:
    """First and last time of each run of ticks at which a mask (k,) holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(float(time[a]), float(time[b - 1])) for a, b in edges.reshape(-1, 2)]
