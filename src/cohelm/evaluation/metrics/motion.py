"""How the chair moved."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.ride import GOAL_RADIUS, Ride
from cohelm.geometry import arc_length, wrap_angle

SHORT_OF_GOAL = 0.3
"""Where a length ends that is not counted on to the goal point, m before it."""


def arrival(ride: Ride) -> int | None:
    """Index of the first tick within 0.2 m of the goal; None: never."""
    there = np.flatnonzero(distance_to_goal(ride) <= GOAL_RADIUS)
    return int(there[0]) if len(there) else None


def distance_to_goal(ride: Ride) -> Floats:
    """(k,), m."""
    away = ride.pose[:, :2] - ride.goal
    return np.hypot(away[:, 0], away[:, 1])


def time(ride: Ride) -> float:
    """Time to the first entry into 0.2 m of the goal, s; NaN where it is never entered."""
    at = arrival(ride)
    return float("nan") if at is None else float(ride.time[at] - ride.time[0])


def path_length(ride: Ride) -> float:
    """Σ‖Δp‖ to the first entry plus what is then left to the goal point, m.

    Where the goal is never entered: all that was driven.
    """
    at = arrival(ride)
    driven = arc_length(ride.pose[:, :2])
    if at is None:
        return float(driven[-1])
    return float(driven[at] + distance_to_goal(ride)[at])


def path_length_short(ride: Ride) -> float:
    """Σ‖Δp‖ to the first entry into 0.3 m of the goal, and nothing for what is left, m.

    Where it is never entered: all that was driven.
    """
    there = np.flatnonzero(distance_to_goal(ride) <= SHORT_OF_GOAL)
    end = int(there[0]) if len(there) else len(ride.pose) - 1
    return float(arc_length(ride.pose[: end + 1, :2])[-1])


def underway(ride: Ride) -> Floats:
    """Twists until the first entry into 0.2 m of the goal, (j, 3); all where there is none."""
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
    """Root mean square; 0 of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def stalled_time(ride: Ride) -> float:
    """Time in which the chair stands still farther than 0.2 m from the goal, s."""
    stalled = ride.standing & (distance_to_goal(ride) > GOAL_RADIUS)
    return float(stalled.sum() * ride.step)
