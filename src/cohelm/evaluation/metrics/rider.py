"""How the chair and the rider got on. Commands are compared as shares of the robot's limits."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.ride import Ride

INTERVENTION = 0.1
"""A difference above this share of the limits is felt."""


def agreement(ride: Ride) -> float:
    """Mean cosine of the angle between asked and given command, both non-zero; else NaN."""
    asked, given = _commands(ride)
    both = _moving(asked) & _moving(given)
    if not both.any():
        return float("nan")
    norms = np.hypot(*asked[both].T) * np.hypot(*given[both].T)
    return float(((asked[both] * given[both]).sum(axis=-1) / norms).mean())


def disagreement(ride: Ride) -> float:
    """Mean ‖asked − given‖ while the stick is deflected; NaN where it never is."""
    return _mean(_difference(ride))


def intervention_share(ride: Ride) -> float:
    """Share of the deflected time in which ‖asked − given‖ > 0.1; NaN where there is none."""
    return _mean(_difference(ride) > INTERVENTION)


def fight_rate(ride: Ride) -> float:
    """Share of the deflected time in which asked and given turn opposite ways; NaN without any."""
    asked, given = _commands(ride)
    deflected = _moving(asked)
    return _mean(asked[deflected, 1] * given[deflected, 1] < 0.0)


def effort(ride: Ride) -> float:
    """∫‖u̇‖dt of the stick, in full deflections; NaN where there is no device."""
    stick = ride.stick[np.isfinite(ride.stick).all(axis=1)]
    return float(np.hypot(*np.diff(stick, axis=0).T).sum()) if len(stick) else float("nan")


def reversals(ride: Ride) -> float:
    """Changes of the stick's sign on either axis, a minute; NaN where there is no device."""
    stick = ride.stick[np.isfinite(ride.stick).all(axis=1)]
    if not len(stick):
        return float("nan")
    count = 0
    for axis in stick.T:
        signs = np.sign(axis[axis != 0.0])
        count += int((np.diff(signs) != 0.0).sum())
    return count / (len(stick) * ride.step / 60.0)


def _commands(ride: Ride) -> tuple[Floats, Floats]:
    """(asked, given) as (v, ω) shares of the robot's limits, (j, 2), where there is a device."""
    there = np.isfinite(ride.asked).all(axis=1)
    limits = np.array([ride.robot.max_speed, ride.robot.max_turn_rate])
    return ride.asked[there][:, [0, 2]] / limits, ride.command[there][:, [0, 2]] / limits


def _difference(ride: Ride) -> Floats:
    asked, given = _commands(ride)
    deflected = _moving(asked)
    apart = asked[deflected] - given[deflected]
    return np.hypot(apart[:, 0], apart[:, 1])


def _moving(command: Floats) -> Booleans:
    moving: Booleans = np.hypot(*command.T) > 1e-6
    return moving


def _mean(values: Floats | Booleans) -> float:
    return float(np.mean(values)) if values.size else float("nan")
