"""Drivetrain: limits, lag and braking between command and state."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Shape, unchecked, value
from cohelm.kernels import CACHED
from cohelm.messages import Decision
from cohelm.robots import Robot, move
from cohelm.robots.kinematics import slowed


@value
class DriveState:
    """State of the drivetrain."""

    pose: Annotated[Floats, Shape("3")]
    """X_MR, true."""
    setpoint: Annotated[Floats, Shape("m")]
    """Set-point of the motor controller after its ramps, inputs of the kinematics."""
    inputs: Annotated[Floats, Shape("m")]
    """Actual inputs."""
    twist: Annotated[Floats, Shape("3")]
    """Actual twist in the robot frame."""


def at_rest(robot: Robot, pose: Floats) -> DriveState:
    """Return the state of a chair at rest at ``pose``."""
    zero = np.zeros(robot.motion_model.inputs)
    return DriveState(pose=pose, setpoint=zero, inputs=zero, twist=np.zeros(3))


@dataclass(frozen=True, slots=True)
class DriveCommand:
    """Command to the motor controller, (m,) each; constant until the next decision."""

    target: Floats
    """Inputs within the speed limits."""
    rise: Floats
    """Maximum rise per second."""
    fall: Floats
    """Maximum fall per second."""
    braking: Floats | None
    """Deceleration of an emergency stop; None: no emergency."""


def drive_command(robot: Robot, decision: Decision) -> DriveCommand:
    """Convert a decision to a command.

    The twist is limited to the robot's speed limits; NaN counts as zero. An emergency brakes with
    the maximum deceleration.
    """
    lower, upper, rise, fall = robot.input_bounds
    target = robot.motion_model.input(decision.twist)
    target = np.where(np.isfinite(target), target, 0.0)
    target = np.minimum(np.maximum(target, lower), upper)
    target = slowed(target, robot.max_speed, robot.motion_model.translating)
    if not decision.emergency:
        return DriveCommand(target, rise, fall, None)
    return DriveCommand(np.zeros_like(target), rise, fall, _emergency_deceleration(robot))


def step_drivetrain(
    robot: Robot,
    state: DriveState,
    command: DriveCommand,
    dt: float,
    grip: Callable[[Floats], Floats] = lambda twist: twist,
) -> DriveState:
    """Return the state ``dt`` later; ``grip`` gives the twist of the chair for that of its motors.

    The set-point follows the command within the acceleration limits, and the wheels follow the
    set-point with a first-order lag; the pose moves on an exact arc.
    """
    setpoint, inputs = controlled(state.setpoint, state.inputs, command, dt, robot.actuation_lag)
    twist = grip(robot.motion_model.twist(inputs))
    pose = move(state.pose, twist, dt)
    return unchecked(state, pose=pose, setpoint=setpoint, inputs=inputs, twist=twist)


def controlled(
    setpoint: Floats, inputs: Floats, command: DriveCommand, dt: float, lag: float
) -> tuple[Floats, Floats]:
    """Return set-point and inputs of the motor controller, (m,) each, ``dt`` later.

    Args:
        setpoint: after the controller's ramps.
        inputs: set-point after the lag.
        command: to follow.
        dt: s.
        lag: time constant from set-point to inputs, s.
    """
    rise, fall, hardest = command.rise, command.fall, command.braking
    if hardest is not None:
        rise = np.where(setpoint < 0.0, np.maximum(rise, hardest), rise)
        fall = np.where(setpoint > 0.0, np.maximum(fall, hardest), fall)
    follow = 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
    return _followed(setpoint, inputs, command.target, -fall * dt, rise * dt, follow)


_STILL = 1e-4
"""Input below which the brakes hold a chair that should stand, m/s or rad/s."""


@njit(**CACHED)
def _followed(
    setpoint: Floats, inputs: Floats, target: Floats, low: Floats, high: Floats, share: float
) -> tuple[Floats, Floats]:
    """Next set-point and inputs, (m,) each.

    low, high: limits of the change of the set-point; share: of the remaining difference by which
    the inputs approach it.
    """
    to, do = np.empty(len(target)), np.empty(len(target))
    for i in range(len(target)):
        to[i] = setpoint[i] + min(max(target[i] - setpoint[i], low[i]), high[i])
        do[i] = inputs[i] + share * (to[i] - inputs[i])
        if to[i] == 0.0 and abs(do[i]) < _STILL:
            do[i] = 0.0
    return to, do


def _emergency_deceleration(robot: Robot) -> Floats:
    """Emergency deceleration (m,) of the inputs that translate the chair, 0 of the others."""
    twists = robot.motion_model.twist(np.eye(robot.motion_model.inputs))
    translates = np.any(twists[:, :2] != 0.0, axis=1)
    return np.where(translates, robot.emergency_deceleration, 0.0)
