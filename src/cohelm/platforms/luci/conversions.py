"""Conversions between LUCI's numbers and cohelm's values; all are pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Floats, Floats32
from cohelm.geometry import compose
from cohelm.platforms.luci.parameters import (
    MAX_DEFLECTION,
    MAX_SPEED,
    MAX_TURN,
    Scaling,
    Wheels,
)

WINDOW = 0.1
"""Time over which the speed is the mean, s: angles have steps, and arrivals jitter."""


def joystick_of(twist: Floats, scaling: Scaling) -> tuple[int, int]:
    """Return the remote joystick (forward_back, left_right), each −100…100, of a twist (3,).

    Positive is forward and right. A twist beyond the limit is shortened along its arc. A number
    that is not finite is a stop.
    """
    v, turn = float(twist[0]), float(twist[2])
    if not (math.isfinite(v) and math.isfinite(turn)):
        return 0, 0
    ahead = v / (scaling.forward_speed if v > 0.0 else scaling.reverse_speed)
    left = turn / scaling.turn_rate
    highest = (scaling.limit - scaling.start) / (MAX_DEFLECTION - scaling.start)
    factor = min(1.0, highest / max(abs(ahead), abs(left), 1e-9))
    return _number(ahead * factor, scaling.start), -_number(left * factor, scaling.start)


def stick_of(message: Any) -> tuple[float, float]:
    """Return the deflection (forward, left), each −1…1, of a JoystickData."""
    forward, left = message.forward_back / MAX_DEFLECTION, -message.left_right / MAX_DEFLECTION
    return min(max(forward, -1.0), 1.0), min(max(left, -1.0), 1.0)


def points_of(message: Any) -> Floats32:
    """Return the points (p, 3) of a CameraPoints, m."""
    found = [each for point in message.points for each in (point.x, point.y, point.z)]
    return np.array(found, dtype=np.float32).reshape(-1, 3)


@dataclass(frozen=True, slots=True)
class WheelOdometry:
    """Pose and twist by the wheels' angles."""

    time: float
    """Time of the newest angles, s."""
    angles: tuple[float, float]
    """Left and right, degrees."""
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """X_OR: the odometry's frame begins where the chair was opened."""
    steps: tuple[tuple[float, float, float], ...] = ()
    """(duration, distance, turn) of the newest steps, s, m, rad; together about WINDOW."""

    @property
    def twist(self) -> Floats:
        """Mean twist (3,) of the window."""
        if not self.steps:
            return np.zeros(3)
        duration, distance, turn = (float(each) for each in np.sum(self.steps, axis=0))
        return np.array([distance / duration, 0.0, turn / duration])


def advanced(
    last: WheelOdometry | None, angles: tuple[float, float], time: float, wheels: Wheels
) -> WheelOdometry:
    """Return the odometry after new angles, degrees; they wrap round at 360°. None: the first ones.

    Raises:
        ValueError: An angle is not a number, or the wheels moved faster than a chair can.
    """
    if not all(map(math.isfinite, angles)):
        raise ValueError(f"wheel angles {angles}")
    if last is None:
        return WheelOdometry(time, angles)
    duration = time - last.time
    if duration <= 0.0:
        return last
    metres = wheels.circumference / (360.0 * wheels.gear_ratio)
    left = _wrapped(angles[0] - last.angles[0]) * (metres if wheels.left_increases else -metres)
    right = _wrapped(angles[1] - last.angles[1]) * (metres if wheels.right_increases else -metres)
    distance, turn = (left + right) / 2.0, (right - left) / wheels.track
    # Several messages may arrive at once: a jump is one beyond the way of a whole window.
    longest = max(duration, WINDOW)
    if abs(distance) > MAX_SPEED * longest or abs(turn) > MAX_TURN * longest:
        raise ValueError(f"wheel angles {angles} after {last.angles} within {duration:.3f} s")
    half = turn / 2.0  # the chord of an arc lies half its angle to the side
    chord = distance * float(np.sinc(half / math.pi))
    moved = [chord * math.cos(half), chord * math.sin(half), turn]
    pose = compose(np.array(last.pose), np.array(moved))
    steps = (*last.steps, (duration, distance, turn))
    while len(steps) > 1 and sum(each[0] for each in steps[1:]) >= WINDOW:
        steps = steps[1:]
    return WheelOdometry(time, angles, (float(pose[0]), float(pose[1]), float(pose[2])), steps)


def _wrapped(degrees: float) -> float:
    return (degrees + 180.0) % 360.0 - 180.0


def _number(share: float, start: int) -> int:
    """Joystick number of a share −1…1 of full speed; below half a unit it is centred."""
    if abs(share) * MAX_DEFLECTION < 0.5:
        return 0
    return round(math.copysign(start + (MAX_DEFLECTION - start) * abs(share), share))
