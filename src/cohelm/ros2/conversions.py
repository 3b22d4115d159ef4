"""Conversions between ROS 2 messages and values beyond those of ``recordings``; all are pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import People
from cohelm.recordings.bags.ros_messages import stamp
from cohelm.recordings.bags.ros_messages import transform as seven
from cohelm.recordings.transforms import fixed_axes, matrix, planar
from cohelm.ros2.parameters import StickParameters

MAX_PEOPLE = 500
"""Maximum number of people in a message."""
_PLACE, _SPEED, _RADIUS = 0.1, 0.2, 0.25
"""Assumed of people from another node: deviations, m and m/s, and the radius of a body, m."""
_UPRIGHT = math.radians(15.0)
"""Maximum tilt of a planar scanner; beyond it its plane hits floor or ceiling."""


class Moving(NamedTuple):
    """Content of an Odometry message."""

    frame: str
    child: str
    time: float
    """Stamp, s."""
    X_OC: Floats
    """(4, 4) pose of the child frame."""
    twist: Floats
    """(3,) in the child frame."""


class StickPosition(NamedTuple):
    """Content of a Joy message."""

    forward: float
    left: float
    held: bool
    """True if the dead-man button is held."""
    confirm: bool


@dataclass(frozen=True, slots=True)
class DeadManButton:
    """Vigilance of a stick whose driver repeats its last message for ever."""

    content: bytes = b""
    """Axes and buttons of the newest message, bit for bit: NaN equals NaN."""
    changed_at: float = -math.inf
    """Time of the newest change, s."""

    def after(self, message: Any, now: float) -> DeadManButton:
        """Return the state after a Joy message."""
        content = np.array([*message.axes, *message.buttons], dtype=float).tobytes()
        return self if content == self.content else DeadManButton(content, now)

    def unchanged(self, now: float, limit: float) -> bool:
        """Check that nothing has changed for longer than ``limit``, s."""
        return now - self.changed_at > limit


def moving(message: Any) -> Moving:
    """Convert an Odometry message.

    Raises:
        ValueError: It has a number that is not finite, or no valid quaternion.
    """
    twist = message.twist.twist
    speeds = np.array([twist.linear.x, twist.linear.y, twist.angular.z])
    pose = seven(message.pose.pose)
    if not np.isfinite([*speeds, *pose]).all() or not math.hypot(*pose[3:]) > 1e-3:
        raise ValueError("an odometry with a number that is not finite, or without orientation")
    return Moving(
        message.header.frame_id,
        message.child_frame_id,
        stamp(message.header),
        matrix(pose),
        speeds,
    )


def twist_at_base(twist: Floats, X_CB: Floats) -> Floats:
    """Return the twist (3,) of the base from that of the odometry's frame C, at X_CB (4, 4)."""
    x, y, yaw = planar(X_CB).tolist()
    velocity = np.array([twist[0] - twist[2] * y, twist[1] + twist[2] * x])
    return np.append(transform([0.0, 0.0, -yaw], velocity), twist[2])


def mount_of(X_RS: Floats) -> Floats:
    """Return the mount (6,) of a sensor: x, y, z, roll, pitch, yaw."""
    return fixed_axes(X_RS)


def is_level(mount: Floats) -> bool:
    """Check that a planar scanner is level, upright or upside down."""
    roll, pitch = abs(float(mount[3])), abs(float(mount[4]))
    return min(roll, abs(math.pi - roll)) <= _UPRIGHT and pitch <= _UPRIGHT


def grid_of(message: Any) -> OccupancyGrid:
    """Convert an OccupancyGrid message.

    Raises:
        ValueError: Its size does not match its data, or its resolution is not positive.
    """
    info = message.info
    rows, cols, resolution = int(info.height), int(info.width), float(info.resolution)
    if rows * cols == 0 or rows * cols != len(message.data):
        raise ValueError(f"a map of {rows} × {cols} cells with {len(message.data)} values")
    if not 1e-3 <= resolution <= 10.0:
        raise ValueError(f"a map with cells of {resolution:g} m")
    data = np.array(message.data, dtype=np.int8).reshape(rows, cols)
    # The type's resolution is single precision: 0.05 arrives as 0.0500000007.
    return OccupancyGrid(
        data=data, resolution=round(resolution, 6), X_MG=planar(matrix(seven(info.origin)))
    )


def people_of(message: Any, time: float, X_MF: Floats, ids: dict[str, int]) -> People:
    """Convert a People message.

    Args:
        message: people_msgs/People.
        time: Its time, s.
        X_MF: (4, 4) pose of its frame in the map.
        ids: Number of each name met so far; new names are added.

    Raises:
        ValueError: A number is not finite, or there are more than 500 people.
    """
    n = len(message.people)
    if n > MAX_PEOPLE:
        raise ValueError(f"{n} people; at most {MAX_PEOPLE} are possible")
    rows = [
        (p.position.x, p.position.y, p.position.z, p.velocity.x, p.velocity.y, p.velocity.z)
        for p in message.people
    ]
    given = np.array(rows, dtype=float).reshape(n, 6)
    if not np.isfinite(given).all():
        raise ValueError("a person with a number that is not finite")
    R, t = X_MF[:3, :3], X_MF[:3, 3]
    place, velocity = given[:, :3] @ R.T + t, given[:, 3:] @ R.T
    variance = np.array([_PLACE, _PLACE, _SPEED, _SPEED]) ** 2
    reliability = np.array([p.reliability for p in message.people], dtype=float)
    return People(
        time=time,
        id=np.array([ids.setdefault(p.name, len(ids)) for p in message.people], dtype=np.int64),
        mean=np.column_stack([place[:, :2], velocity[:, :2]]),
        covariance=np.tile(np.diag(variance), (n, 1, 1)),
        heading=np.full(n, np.nan),
        radius=np.full(n, _RADIUS),
        confidence=np.clip(np.nan_to_num(reliability), 0.0, 1.0),
        source="ros2",
    )


def stick_of(message: Any, parameters: StickParameters) -> StickPosition:
    """Convert a Joy message.

    Raises:
        ValueError: It lacks an axis or a button, or an axis is not a number.
    """
    axes, buttons = message.axes, message.buttons
    needed = max(parameters.forward_axis, parameters.left_axis)
    if len(axes) <= needed:
        raise ValueError(f"a Joy with {len(axes)} axes: axis {needed} is missing")
    forward, left = (float(axes[k]) for k in (parameters.forward_axis, parameters.left_axis))
    if not (math.isfinite(forward) and math.isfinite(left)):
        raise ValueError("a Joy with an axis that is not a number")

    if parameters.dead_man is not None and len(buttons) <= parameters.dead_man:
        raise ValueError(f"a Joy with {len(buttons)} buttons: {parameters.dead_man} is missing")
    return StickPosition(
        min(max(forward, -1.0), 1.0),
        min(max(left, -1.0), 1.0),
        is_pressed(message, parameters.dead_man),
        is_pressed(message, parameters.confirm),
    )


def is_pressed(message: Any, button: int | None) -> bool:
    """Check a button of a Joy message; one that is not there is not pressed."""
    buttons = message.buttons
    return button is not None and button < len(buttons) and bool(buttons[button])
