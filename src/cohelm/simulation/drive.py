"""From the command to the wheels: limits, lag and braking."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
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


def drive(robot: Robot, wheels: Wheels, decision: Decision, dt: float) -> Wheels:
    """The drive ``dt`` later.

    The command is cut to the robot's speed limits, the set-point follows it within the acceleration
    limits, and the wheels follow the set-point with a first-order lag; the pose moves on an exact
    arc. An emergency brakes as hard as the chair can. A command that is not a number counts as
    zero.
    """
    lower, upper, rise, fall = robot.motion.bounds(robot.limits)
    wanted = np.nan_to_num(robot.motion.input(decision.twist), posinf=0.0, neginf=0.0)
    wanted = np.clip(wanted, lower, upper)
    wanted = slowed(wanted, robot.max_speed, robot.motion.translating)
    if decision.emergency:
        wanted = np.zeros_like(wanted)
        hardest = _hardest_braking(robot)
        rise = np.where(wheels.setpoint < 0.0, np.maximum(rise, hardest), rise)
        fall = np.where(wheels.setpoint > 0.0, np.maximum(fall, hardest), fall)
    setpoint = wheels.setpoint + np.clip(wanted - wheels.setpoint, -fall * dt, rise * dt)
    lag = robot.actuation_lag
    follow = 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
    inputs = wheels.inputs + follow * (setpoint - wheels.inputs)
    inputs = np.where((setpoint == 0.0) & (np.abs(inputs) < _STILL), 0.0, inputs)
    twist = robot.motion.twist(inputs)
    return Wheels(pose=move(wheels.pose, twist, dt), setpoint=setpoint, inputs=inputs, twist=twist)


_STILL = 1e-4
"""Below this an input that is to be zero is zero (the brakes hold), m/s or rad/s."""


def _hardest_braking(robot: Robot) -> Floats:
    """(m,) the emergency deceleration for the inputs that translate the chair, 0 for the others."""
    twists = robot.motion.twist(np.eye(robot.motion.inputs))
    translates = np.any(twists[:, :2] != 0.0, axis=1)
    return np.where(translates, robot.emergency_deceleration, 0.0)
