"""Cooperation of rider and chair; commands are shares of the robot's limits."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.episode.ride import Ride

TIGHT = 0.3
"""Distance from walls below which a place is tight, m."""
_PUSHED = 0.05
"""Deflection, or speed in m/s, from which the rider pushes."""
_SHORTEST = 2.0
"""Shortest time of pushing that says something about a rider, s."""
_MEAN_TIME = 0.5
"""Time over which the mean of the stick is taken, s."""
INTERVENTION = 0.1
"""Difference of commands above which the chair intervenes, as a share of the limits."""


def agreement(ride: Ride) -> float:
    """Mean cosine between requested and executed command where both are non-zero; else NaN."""
    requested, executed = _commands(ride)
    both = _moving(requested) & _moving(executed)
    if not both.any():
        return float("nan")
    norms = np.hypot(*requested[both].T) * np.hypot(*executed[both].T)
    return float(((requested[both] * executed[both]).sum(axis=-1) / norms).mean())


def disagreement(ride: Ride) -> float:
    """Mean ‖requested − executed‖ while the stick is deflected; NaN where it never is."""
    return _mean(_difference(ride))


def intervention_share(ride: Ride) -> float:
    """Share of the deflected time in which ‖requested − executed‖ > 0.1; NaN without any."""
    return _mean(_difference(ride) > INTERVENTION)


def conflict_share(ride: Ride) -> float:
    """Share of the deflected time in which requested and executed turn oppose; NaN without any."""
    requested, executed = _commands(ride)
    deflected = _moving(requested)
    return _mean(requested[deflected, 1] * executed[deflected, 1] < 0.0)


def effort(ride: Ride) -> float:
    """∫‖u̇‖dt of the stick, in full deflections; NaN without a device."""
    stick = ride.stick[np.isfinite(ride.stick).all(axis=1)]
    return float(np.hypot(*np.diff(stick, axis=0).T).sum()) if len(stick) else float("nan")


def reversals(ride: Ride) -> float:
    """Sign changes of the stick on either axis, 1/min; NaN without a device."""
    stick = ride.stick[np.isfinite(ride.stick).all(axis=1)]
    if not len(stick):
        return float("nan")
    count = 0
    for axis in stick.T:
        signs = np.sign(axis[axis != 0.0])
        count += int((np.diff(signs) != 0.0).sum())
    return count / (len(stick) * ride.step / 60.0)


def tight_speed(ride: Ride) -> float:
    """Median speed that the rider asks for within 0.3 m of walls, m/s; NaN below 2 s of that."""
    pushed = np.isfinite(ride.requested).all(axis=1) & (ride.requested[:, 0] > _PUSHED)
    asked = ride.requested[pushed & (ride.gap_wall < TIGHT), 0]
    return float(np.median(asked)) if len(asked) * ride.step >= _SHORTEST else float("nan")


def turn_share(ride: Ride) -> float:
    """90th percentile of the turn that the rider asks for, as a share of the robot's; else NaN."""
    requested, _ = _commands(ride)
    turns = np.abs(requested[_moving(requested), 1])
    return float(np.percentile(turns, 90)) if len(turns) * ride.step >= _SHORTEST else float("nan")


def steadiness(ride: Ride) -> float:
    """Steadiness of the hand: 1 less the share of the stick that a mean over 0.5 s removes.

    The share is that of RMS values while the stick is deflected; NaN below 2 s of that.
    """
    stick = ride.stick[np.isfinite(ride.stick).all(axis=1)]
    deflected = np.hypot(*stick.T) > _PUSHED
    if deflected.sum() * ride.step < _SHORTEST:
        return float("nan")
    count = max(round(_MEAN_TIME / ride.step), 1)
    kernel = np.full(count, 1.0 / count)
    mean = np.stack([np.convolve(axis, kernel, mode="same") for axis in stick.T], axis=1)
    # the first and last means are over a released stick as well
    inside = deflected & (np.convolve(deflected, kernel, mode="same") > 1.0 - 0.5 / count)
    if not inside.any():
        return float("nan")
    rest, whole = (stick - mean)[inside], stick[inside]
    return float(max(1.0 - np.sqrt((rest**2).sum() / (whole**2).sum()), 0.0))


def _commands(ride: Ride) -> tuple[Floats, Floats]:
    """(requested, executed) as (v, ω) shares of the limits, (j, 2), at ticks with a device."""
    there = np.isfinite(ride.requested).all(axis=1)
    limits = np.array([ride.robot.max_speed, ride.robot.max_turn_rate])
    return ride.requested[there][:, [0, 2]] / limits, ride.command[there][:, [0, 2]] / limits


def _difference(ride: Ride) -> Floats:
    requested, executed = _commands(ride)
    deflected = _moving(requested)
    apart = requested[deflected] - executed[deflected]
    return np.hypot(apart[:, 0], apart[:, 1])


def _moving(command: Floats) -> Booleans:
    moving: Booleans = np.hypot(*command.T) > 1e-6
    return moving


def _mean(values: Floats | Booleans) -> float:
    return float(np.mean(values)) if values.size else float("nan")
