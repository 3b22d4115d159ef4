"""Speed controller of the twin's two drive motors."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.robots import Robot
from cohelm.robots.chassis import Chassis
from cohelm.simulation.drivetrain import DriveCommand, controlled
from cohelm.simulation.simulated_chair import Grip

PARKED = 0.05
"""Wheel speed below which the parking brakes engage when the command is zero, rad/s (assumed)."""
BRAKE_TORQUE = 150.0
"""Torque that a parking brake holds, N m (assumed: more than the motor's)."""


@value
class MotorState:
    """Memory of the controller."""

    setpoint: Annotated[Floats, Shape("m")]
    """After the ramps, inputs of the kinematics."""
    inputs: Annotated[Floats, Shape("m")]
    """After the lag."""
    expected: Annotated[Floats, Shape("2")]
    """Speeds that the wheels would have without friction, rad/s."""
    integral: Annotated[Floats, Shape("2")]
    """Integral action of the left and the right wheel, rad/s."""


@value
class SpeedCommand:
    """Command to the wheels until the next call."""

    speed: Annotated[Floats, Shape("2")]
    """Speed that the proportional controller follows, rad/s."""
    parked: bool
    """True: the parking brakes hold."""


def motors_at_rest(robot: Robot) -> MotorState:
    """Return the state of a controller at rest."""
    zero = np.zeros(robot.motion_model.inputs)
    return MotorState(setpoint=zero, inputs=zero, expected=np.zeros(2), integral=np.zeros(2))


def control_wheels(
    robot: Robot,
    state: MotorState,
    command: DriveCommand,
    dt: float,
    measured: Floats,
    grip: Grip = lambda twist: twist,
) -> tuple[MotorState, SpeedCommand]:
    """Follow a command with limited acceleration and a lag, and compensate friction.

    The lag of the filter and that of the proportional controller add up to ``actuation_lag``.

    Args:
        robot: with a chassis.
        state: before.
        command: constant over ``dt``.
        dt: s.
        measured: (2,) speeds of the wheels, rad/s.
        grip: changes the twist that the wheels are to drive, for faults.
    """
    chassis = chassis_of(robot)
    motors = chassis.motors
    answer = 1.0 / (2.0 * math.pi * motors.bandwidth)
    lag = max(robot.actuation_lag - answer, 0.0)
    setpoint, inputs = controlled(state.setpoint, state.inputs, command, dt, lag)
    wanted = wheel_speeds(chassis, grip(robot.motion_model.twist(inputs)))
    parked = not setpoint.any() and bool((np.abs(measured) < PARKED).all())
    # Only the difference from the expected answer is integrated: no overshoot without friction.
    expected = wanted + math.exp(-dt / answer) * (state.expected - wanted)
    integral = state.integral + motors.integral * dt * (state.expected - measured)
    # Beyond what saturates the torque, the integral would only delay the answer.
    limit = motors.torque / speed_gain(chassis)
    integral = np.zeros(2) if parked else np.clip(integral, -limit, limit)
    after = MotorState(setpoint=setpoint, inputs=inputs, expected=expected, integral=integral)
    return after, SpeedCommand(speed=wanted + integral, parked=parked)


def speed_gain(chassis: Chassis) -> float:
    """Gain of the speed controller of one wheel, N m s/rad, for its bandwidth."""
    inertia = chassis.total_mass / 2.0 * chassis.drive.radius**2
    return 2.0 * math.pi * chassis.motors.bandwidth * inertia


def wheel_speeds(chassis: Chassis, twist: Floats) -> Floats:
    """Speeds (2,) of the left and the right wheel for a twist (3,), rad/s."""
    v, _, turn = twist
    half = chassis.drive.track / 2.0
    return np.array([v - turn * half, v + turn * half]) / chassis.drive.radius


def twist_of_wheels(chassis: Chassis, speeds: Floats) -> Floats:
    """Twist (3,) that the wheels' speeds (2,), rad/s, give without slip."""
    left, right = chassis.drive.radius * speeds
    return np.array([(left + right) / 2.0, 0.0, (right - left) / chassis.drive.track])


def chassis_of(robot: Robot) -> Chassis:
    """Return the chassis of a robot.

    Raises:
        ValueError: It has none.
    """
    if robot.chassis is None:
        raise ValueError(f"robot {robot.name!r} has no chassis")
    return robot.chassis
