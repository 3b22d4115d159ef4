"""Predicted braking of a robot, shared by planners and safety gate."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED
from cohelm.robots.robot import Robot

STANDING = 0.02
"""A robot slower than this stands, m/s and rad/s."""


def braking(
    robot: Robot,
    pose: Floats,
    now: Floats,
    command: Floats,
    *,
    hold: float,
    deceleration: float,
    step: float,
) -> Floats:
    """Poses (k, 3) of a command that is obeyed for a while, then of braking along the same arc.

    The turn must end as well, which takes longer than the speed where the robot turns on the spot.
    The wheels lag behind their set-point.

    Args:
        robot: its kinematics and limits.
        pose: X_MR, (3,).
        now: current input, (m,); it changes no faster than the limits allow.
        command: input (m,).
        hold: time for which the command acts, s, the lag of the drive included.
        deceleration: of braking, m/s².
        step: between poses, s.
    """
    _, _, rise, fall = robot.input_bounds
    inputs = _braking_inputs(
        now, command, rise, fall, (hold, deceleration, robot.actuation_lag, step)
    )
    return robot.motion_model.rollout(pose, inputs, step)


@njit(**CACHED)
def _braking_inputs(
    now: Floats,
    command: Floats,
    rise: Floats,
    fall: Floats,
    times: tuple[float, float, float, float],
) -> Floats:
    """Inputs (k, m) of :func:`braking`: all fade together, in the time that the slowest one needs.

    The last input is the turn rate, all others are speeds.
    times: (hold, s; deceleration, m/s²; lag, s; step, s).
    """
    hold, deceleration, lag, step = times
    m = len(now)
    # inputs at the end of the hold, and their norm
    peak = np.empty(m)
    speed = 0.0
    for i in range(m):
        peak[i] = now[i] + min(max(command[i] - now[i], -fall[i] * hold), rise[i] * hold)
        if i < m - 1:
            speed += peak[i] * peak[i]
    # duration of the ramp, and of the tail that the lag adds until the robot stands
    fading = max(math.sqrt(speed) / deceleration, abs(peak[m - 1]) / fall[m - 1], 1e-3)
    greatest = max(math.sqrt(speed), abs(peak[m - 1]))
    begins = max(hold - lag, 0.0)
    tail = lag * math.log(max(greatest * lag / fading, STANDING) / (0.5 * STANDING))
    count = math.ceil((max(begins + fading + tail, hold)) / step - 1e-9)
    out = np.empty((max(count, 2), m))
    for k in range(len(out)):
        left = _lagged((k + 0.5) * step - begins, fading, lag)
        for i in range(m):
            change = min((k + 1.0) * step, hold)
            acting = now[i] + min(max(command[i] - now[i], -fall[i] * change), rise[i] * change)
            out[k, i] = left * acting
    return out


@njit(**CACHED, inline="always")
def _lagged(time: float, fading: float, lag: float) -> float:
    """Remaining share of an input, ``time`` after its set-point began to fade: a lagged ramp."""
    if time <= 0.0:
        return 1.0
    if lag <= 0.0:
        return max(1.0 - time / fading, 0.0)
    ramp = min(time, fading)
    left = 1.0 - (ramp - lag * (1.0 - math.exp(-ramp / lag))) / fading
    return left * math.exp(-(time - ramp) / lag)
