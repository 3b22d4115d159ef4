"""Command against motion: a band of speeds that sound motors and brakes can reach.

Two first-order models with ramps follow the command: a quick one with the hardest ramps and half
the lag, and a slow one with weak ramps and a delay. Measured speeds outside the band of both are
integrated; an integral beyond its bound is a fault.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from cohelm.health.parameters import HealthParameters
from cohelm.kernels import CACHED
from cohelm.messages import Observation, Reason
from cohelm.robots import Robot

_MAX_GAP = 0.25
"""Time between two observations after which the band begins anew, s."""
_WEAK = 0.75
"""Share of the stated ramps that a sound drive reaches at least."""
_STRONG = 1.3
_WINDOW = 1.0
"""Time constant in which excess is forgotten, s."""


class AxisBand(NamedTuple):
    """Band of one component of the twist, and what was measured outside it."""

    quick: float
    slow: float
    slow_command: float
    """Command as the slow model receives it."""
    over: float = 0.0
    """Integral of motion that the command does not explain, m or rad."""
    lacking: float = 0.0
    """Integral of commanded motion that is missing, m or rad."""


class DriveBand(NamedTuple):
    """Memory of the comparison."""

    time: float
    linear: AxisBand
    angular: AxisBand


def update_drive(
    memory: DriveBand | None, observation: Observation, robot: Robot, p: HealthParameters
) -> tuple[DriveBand | None, Reason | None]:
    """Compare the measured twist with the commands so far.

    Returns:
        (memory for the next call, symptom or None).
    """
    command = observation.command
    v, w = float(observation.twist[0]), float(observation.twist[2])
    now = observation.time
    if command is None:
        return None, None
    if memory is None or not 0.0 < now - memory.time <= _MAX_GAP:
        start = (AxisBand(v, v, v), AxisBand(w, w, w))
        return DriveBand(now, *start), None
    dt, lag = now - memory.time, robot.actuation_lag
    linear = AxisBand(
        *_follow(
            memory.linear,
            float(command[0]),
            v,
            dt,
            lag,
            (robot.max_acceleration, robot.max_deceleration, robot.emergency_deceleration),
            p.drive_margin,
        )
    )
    turn = robot.max_turn_acceleration
    angular = AxisBand(
        *_follow(memory.angular, float(command[2]), w, dt, lag, (turn, turn, turn), p.turn_margin)
    )
    band = DriveBand(now, linear, angular)
    if linear.over > p.drive_excess or angular.over > 2.0 * p.drive_excess:
        return band, Reason.DRIVE_FAULT
    if linear.lacking > 8.0 * p.drive_excess:
        return band, Reason.DRIVE_FAULT
    if linear.lacking > 1.2 * p.drive_excess or angular.lacking > 4.0 * p.drive_excess:
        return band, Reason.DRIVE_WEAK
    return band, None


@njit(**CACHED)
def _follow(
    band: AxisBand,
    command: float,
    measured: float,
    dt: float,
    lag: float,
    ramps: tuple[float, float, float],
    margin: tuple[float, float],
) -> tuple[float, float, float, float, float]:
    rise, fall, hardest = ramps
    quick = _ramped(band.quick, command, _STRONG * rise * dt, _STRONG * hardest * dt)
    delayed = band.slow_command + (command - band.slow_command) * (
        1.0 - math.exp(-dt / (1.5 * lag + 0.08))
    )
    slow = _ramped(band.slow, delayed, _WEAK * rise * dt, _WEAK * fall * dt)
    low, high = min(quick, slow), max(quick, slow)
    allowed = margin[0] + margin[1] * max(abs(low), abs(high))
    above, below = measured - high - allowed, low - allowed - measured
    # Motion against the band or beyond it is not commanded; motion short of it is lacking.
    over, lacking = 0.0, 0.0
    if above > 0.0:
        over, lacking = (above, 0.0) if high >= 0.0 or measured > 0.0 else (0.0, above)
    elif below > 0.0:
        over, lacking = (below, 0.0) if low <= 0.0 or measured < 0.0 else (0.0, below)
    keep = math.exp(-dt / _WINDOW)
    over = keep * band.over + over * dt if over > 0.0 else keep * band.over
    lacking = keep * band.lacking + lacking * dt if lacking > 0.0 else keep * band.lacking
    return quick, slow, delayed, over, lacking


@njit(**CACHED)
def _ramped(value: float, target: float, rise: float, fall: float) -> float:
    """Value that approaches the target: away from zero by ``rise``, towards zero by ``fall``."""
    if target > value:
        return min(target, value + (rise if value >= 0.0 else fall))
    return max(target, value - (rise if value <= 0.0 else fall))
