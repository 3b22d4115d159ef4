"""From the command to the wheels: limits, lag and braking."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Shape, unchecked, value
from cohelm.messages import Decision
from cohelm.robots import Robot, move
from cohelm.robots.kinematics import slowed


@value
class Wheels:
    """The state of the drive."""

    pose: Annotated[Floats, Shape("3")]
    """X_MR, true."""
    setpoint: Annotated[Floats, Shape("m")]
    """What the motor controller asks for after its ramps, in the kinematics' inputs."""
    inputs: Annotated[Floats, Shape("m")]
    """What the wheels do."""
    twist: Annotated[Floats, Shape("3")]
    """The same as a twist in the robot frame."""


def at_rest(robot: Robot, pose: Floats) -> Wheels:
    """A chair that stands at ``pose``."""
    nothing = np.zeros(robot.motion.inputs)
    return Wheels(pose=pose, setpoint=nothing, inputs=nothing, twist=np.zeros(3))


@dataclass(frozen=True, slots=True)
class Ordered:
    """A decision as the motor controller takes it, (m,) each; the same until the next one."""

    wanted: Floats
    """Inputs within the robot's speed limits."""
    rise: Floats
    """Greatest rise a second."""
    fall: Floats
    """Greatest fall a second."""
    braking: Floats | None
    """How hard an emergency brakes; None: there is none."""


def ordered(robot: Robot, decision: Decision) -> Ordered:
    """What a decision asks of the drive.

    The command is cut to the robot's speed limits; one that is not a number counts as zero. An
    emergency brakes as hard as the chair can.
    """
    lower, upper, rise, fall = robot.input_bounds
    wanted = robot.motion.input(decision.twist)
    wanted = np.where(np.isfinite(wanted), wanted, 0.0)
    wanted = np.minimum(np.maximum(wanted, lower), upper)
    wanted = slowed(wanted, robot.max_speed, robot.motion.translating)
    if not decision.emergency:
        return Ordered(wanted, rise, fall, None)
    return Ordered(np.zeros_like(wanted), rise, fall, _hardest_braking(robot))


def drive(robot: Robot, wheels: Wheels, order: Ordered, dt: float) -> Wheels:
    """The drive ``dt`` later.

    The set-point follows the order within the acceleration limits, and the wheels follow the
    set-point with a first-order lag; the pose moves on an exact arc.
    """
    rise, fall, hardest = order.rise, order.fall, order.braking
    if hardest is not None:
        rise = np.where(wheels.setpoint < 0.0, np.maximum(rise, hardest), rise)
        fall = np.where(wheels.setpoint > 0.0, np.maximum(fall, hardest), fall)
    lag = robot.actuation_lag
    follow = 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
    setpoint, inputs = _followed(
        wheels.setpoint, wheels.inputs, order.wanted, -fall * dt, rise * dt, follow
    )
    twist = robot.motion.twist(inputs)
    pose = move(wheels.pose, twist, dt)
    return unchecked(wheels, pose=pose, setpoint=setpoint, inputs=inputs, twist=twist)


_STILL = 1e-4
"""Below this an input that is to be zero is zero (the brakes hold), m/s or rad/s."""


@njit(cache=True)
def _followed(
    setpoint: Floats, inputs: Floats, wanted: Floats, least: Floats, most: Floats, follow: float
) -> tuple[Floats, Floats]:
    """The next set-point and inputs, (m,) each; least and most: by how much the first may change.

    follow: by what share of their difference the inputs come nearer to it.
    """
    to, do = np.empty(len(wanted)), np.empty(len(wanted))
    for i in range(len(wanted)):
        to[i] = setpoint[i] + min(max(wanted[i] - setpoint[i], least[i]), most[i])
        do[i] = inputs[i] + follow * (to[i] - inputs[i])
        if to[i] == 0.0 and abs(do[i]) < _STILL:
            do[i] = 0.0
    return to, do


def _hardest_braking(robot: Robot) -> Floats:
    """(m,) the emergency deceleration for the inputs that translate the chair, 0 for the others."""
    twists = robot.motion.twist(np.eye(robot.motion.inputs))
    translates = np.any(twists[:, :2] != 0.0, axis=1)
    return np.where(translates, robot.emergency_deceleration, 0.0)
