"""Where the robot of a bag is, and its sensors on it: which frames to believe.

The robot's frame is ``base_footprint``, ``base_link`` or the child of the odometry, the first of
these that the bag knows; the map's is ``map``, ``odom``, ``world`` or the frame of the odometry,
the first with which the robot is connected. A bag that tells of no robot is that of a sensor: its
frame is the robot's. Where nothing connects the robot with a map, it is told to be at (0, 0, 0).
"""

from __future__ import annotations

import array
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import wrap_angle
from cohelm.recordings.ros_messages import ODOMETRY, OLD_TRANSFORMS, TRANSFORMS, stamp, transform
from cohelm.recordings.transforms import FARTHEST, Transforms, fixed_axes, name, planar

KINDS = frozenset({ODOMETRY, TRANSFORMS, OLD_TRANSFORMS})
"""The messages that tell of places."""

_ON_THE_FLOOR = "base_footprint"
_ROBOTS = (_ON_THE_FLOOR, "base_link")
_MAPS = ("map", "odom", "world")
_STALE = 0.5
"""Beyond it a twist or a transform is old, s."""
_STEP = 0.1
"""Over which a twist is measured where no odometry tells it, s."""


class Place(NamedTuple):
    """Where a sensor was."""

    pose: Floats
    """X_MR, (3,)."""
    twist: Floats
    """In the robot's frame, (3,)."""
    mount: Floats
    """X_RS, (6,); z is NaN unless the robot's frame lies on the floor."""
    told: bool
    """Whether anything says where the robot was."""


class Whereabouts:
    """What a bag says of places: noted in a first reading, asked in a second."""

    def __init__(self) -> None:
        self.warnings: list[str] = []
        """What had to be assumed."""
        self._transforms = Transforms()
        self._odometry = array.array("d")
        self._frames: tuple[str, str, str] | None = None
        self._twists = np.empty((0, 4))
        self._chosen: dict[str, tuple[str, str | None]] = {}

    def note(self, message: Any, type_: str, topic: str, received: float) -> None:
        """Take note of a message of one of ``KINDS``; of several odometries the first counts."""
        if type_ != ODOMETRY:
            static = topic.rstrip("/").endswith("tf_static")
            for entry in message.transforms:
                time = -math.inf if static else stamp(entry.header) or received
                frames = entry.header.frame_id, entry.child_frame_id
                self._transforms.note(*frames, time, transform(entry.transform))
            return
        parent, child = name(message.header.frame_id), name(message.child_frame_id)
        told = topic, parent or "odom", child or "base_link"
        self._frames = self._frames or told
        twist = message.twist.twist
        row = (*transform(message.pose.pose), twist.linear.x, twist.linear.y, twist.angular.z)
        if told == self._frames and all(abs(number) < FARTHEST for number in row):
            self._odometry.extend((stamp(message.header) or received, *row))

    def settle(self) -> None:
        """End the first reading; odometry says where the robot is only if tf does not."""
        rows = np.array(self._odometry).reshape(-1, 11)
        if self._frames is None or len(rows) == 0:
            return
        _, parent, child = self._frames
        if not self._transforms.held(child):
            for row in rows.tolist():
                self._transforms.note(parent, child, row[0], row[1:8])
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        self._twists = rows[:, [0, 8, 9, 10]]

    def place(self, sensor: str, time: float) -> Place:
        """Where the sensor with that frame was, with its robot, at ``time``."""
        sensor = name(sensor)
        if sensor not in self._chosen:
            self._chosen[sensor] = self._choose(sensor)
        robot, fixed = self._chosen[sensor]
        X_MR = np.eye(4) if fixed is None else self._transforms.at(fixed, robot, time)
        mount = np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])
        if robot == sensor:
            mount[3:5] = fixed_axes(X_MR)[3:5]
        elif self._transforms.connected(robot, sensor):
            mount = fixed_axes(self._transforms.at(robot, sensor, time))
            if _last(robot) != _ON_THE_FLOOR:
                mount[2] = np.nan
        return Place(planar(X_MR), self._twist(robot, fixed, time), mount, fixed is not None)

    def _choose(self, sensor: str) -> tuple[str, str | None]:
        """(the robot's frame, the map's or None)."""
        of_odometry = self._frames[1:] if self._frames else ()
        robots = self._known([*_ROBOTS, *of_odometry[1:]])
        mounted = [frame for frame in robots if self._transforms.connected(frame, sensor)]
        robot = [*mounted, *robots, sensor][0]
        if robots and not mounted:
            self._warn(f"tells nothing of where {sensor!r} is on {robot!r}: taken as right there")
        maps = self._known([*_MAPS, *of_odometry[:1]])
        fixed = [f for f in maps if f != robot and self._transforms.connected(f, robot)]
        if not fixed:
            self._warn(f"tells nothing of where {robot!r} is")
        return robot, fixed[0] if fixed else None

    def _known(self, names: Iterable[str]) -> list[str]:
        """The bag's frames that are called so, whatever the robot's own name before it."""
        frames = self._transforms.frames
        return [f for called in names for f in frames if called in {f, _last(f)}]

    def _twist(self, robot: str, fixed: str | None, time: float) -> Floats:
        times = self._twists[:, 0]
        of_robot = self._frames is not None and robot in {*_ROBOTS, self._frames[2]}
        if of_robot and len(times) and np.min(np.abs(times - time)) <= _STALE:
            return np.array([np.interp(time, times, self._twists[:, k]) for k in (1, 2, 3)])
        if fixed is None:
            return np.zeros(3)
        if self._transforms.beyond(fixed, robot, time) > _STALE:
            self._warn(
                f"tells nothing of where {robot!r} is near {time:.3f} s: taken as it was or will be"
            )
        before, after = (
            planar(self._transforms.at(fixed, robot, time + d)) for d in (-_STEP / 2, _STEP / 2)
        )
        dx, dy = (after - before)[:2] / _STEP
        yaw = planar(self._transforms.at(fixed, robot, time))[2]
        turn = float(wrap_angle(after[2] - before[2])) / _STEP
        cos, sin = math.cos(yaw), math.sin(yaw)
        return np.array([cos * dx + sin * dy, cos * dy - sin * dx, turn])

    def _warn(self, text: str) -> None:
        if text.partition(" near ")[0] not in {w.partition(" near ")[0] for w in self.warnings}:
            self.warnings.append(text)


def _last(frame: str) -> str:
    return frame.rpartition("/")[2]
