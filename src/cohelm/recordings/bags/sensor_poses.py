"""Poses of a bag's robot and of its sensors, from tf and odometry.

The robot's frame is ``base_footprint``, ``base_link`` or the child of the odometry, the first of
these that the bag contains; the map's is ``map``, ``odom``, ``world`` or the frame of the odometry,
the first with which the robot is connected. In a bag without a robot, the
sensor's frame is the robot's. A robot that nothing connects with a map is at (0, 0, 0).
"""

from __future__ import annotations

import array
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import wrap_angle
from cohelm.recordings.bags.clocks import Alignment, StampClocks
from cohelm.recordings.bags.ros_messages import (
    ODOMETRY,
    OLD_TRANSFORMS,
    TRANSFORMS,
    stamp,
    transform,
)
from cohelm.recordings.transforms import MAX_COORDINATE, Transforms, fixed_axes, name, planar

POSE_TYPES = frozenset({ODOMETRY, TRANSFORMS, OLD_TRANSFORMS})
"""Types of messages with poses."""

_ON_THE_FLOOR = "base_footprint"
_ROBOTS = (_ON_THE_FLOOR, "base_link")
_MAPS = ("map", "odom", "world")
_STALE = 0.5
"""Maximum age of a twist or a transform, s."""
_STEP = 0.1
"""Interval of a twist from tf, where there is no odometry, s."""


class SensorPose(NamedTuple):
    """Pose of the robot and mount of a sensor at one time."""

    pose: Floats
    """X_MR, (3,)."""
    twist: Floats
    """In the robot's frame, (3,)."""
    mount: Floats
    """X_RS, (6,); z is NaN unless the robot's frame lies on the floor."""
    known: bool
    """True where the bag has the robot's pose."""
    mounted: bool = True
    """False where the bag does not say where on a robot the sensor is."""


class SensorPoses:
    """Poses in a bag: collected in a first pass, looked up in a second.

    Args:
        clocks: Takes the stamps.
    """

    def __init__(self, clocks: StampClocks) -> None:
        self._clocks = clocks
        self.warnings: list[str] = []
        """Assumptions made."""
        self._transforms = Transforms()
        self._unstamped: list[tuple[str, str, float, tuple[float, ...]]] = []
        """Parent, child, time of reception, transform."""
        self._odometry = array.array("d")
        """Stamp, pose, twist and time of reception, 12 numbers each."""
        self._frames: tuple[str, str, str] | None = None
        self._twists = np.empty((0, 4))
        self._chosen: dict[str, tuple[str, str | None]] = {}

    def add(self, message: Any, type_: str, topic: str, received: float) -> None:
        """Add a message of one of ``POSE_TYPES``; of several odometries the first is used."""
        if type_ != ODOMETRY:
            static = topic.rstrip("/").endswith("tf_static")
            for entry in message.transforms:
                time = -math.inf if static else stamp(entry.header)
                frames = entry.header.frame_id, entry.child_frame_id
                if time == 0.0:
                    self._unstamped.append((*frames, received, transform(entry.transform)))
                    continue
                self._transforms.add(*frames, time, transform(entry.transform))
                if not static:
                    self._clocks.add(_stream(name(entry.child_frame_id)), time, received)
            return
        parent, child = name(message.header.frame_id), name(message.child_frame_id)
        source = topic, parent or "odom", child or "base_link"
        self._frames = self._frames or source
        twist = message.twist.twist
        row = (*transform(message.pose.pose), twist.linear.x, twist.linear.y, twist.angular.z)
        if source == self._frames and all(abs(number) < MAX_COORDINATE for number in row):
            self._odometry.extend((stamp(message.header), *row, received))
            self._clocks.add(topic, stamp(message.header), received)

    def finish(self, clock: Alignment) -> None:
        """End the first pass; odometry gives the pose only if tf does not."""
        for frame in self._transforms.frames:
            self._transforms.shift(frame, -clock.shifts.get(_stream(frame), 0.0))
        for parent, child, received, pose in self._unstamped:
            self._transforms.add(parent, child, received + clock.reception, pose)
        rows = np.array(self._odometry).reshape(-1, 12)
        if self._frames is None or len(rows) == 0:
            return
        topic, parent, child = self._frames
        rows[:, 0] = [clock.time(topic, row[0], row[-1]) for row in rows.tolist()]
        if not self._transforms.has_parent(child):
            for row in rows.tolist():
                self._transforms.add(parent, child, row[0], row[1:8])
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        self._twists = rows[:, [0, 8, 9, 10]]

    def at(self, sensor: str, time: float) -> SensorPose:
        """Pose of the robot and mount of the sensor with that frame at ``time``."""
        sensor = name(sensor)
        if sensor not in self._chosen:
            self._chosen[sensor] = self._choose(sensor)
        robot, fixed = self._chosen[sensor]
        X_MR = np.eye(4) if fixed is None else self._transforms.at(fixed, robot, time)
        mount, mounted = np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0]), True
        if robot == sensor:
            mount[3:5], mounted = fixed_axes(X_MR)[3:5], False
        elif self._transforms.connected(robot, sensor):
            mount = fixed_axes(self._transforms.at(robot, sensor, time))
            if _last(robot) != _ON_THE_FLOOR:
                mount[2] = np.nan
        return SensorPose(
            planar(X_MR), self._twist(robot, fixed, time), mount, fixed is not None, mounted
        )

    def _choose(self, sensor: str) -> tuple[str, str | None]:
        """The robot's frame, and the map's or None."""
        of_odometry = self._frames[1:] if self._frames else ()
        robots = self._known([*_ROBOTS, *of_odometry[1:]])
        mounted = [frame for frame in robots if self._transforms.connected(frame, sensor)]
        robot = [*mounted, *robots, sensor][0]
        if robots and not mounted:
            self._warn(f"no transform from {robot!r} to {sensor!r}: assumed to coincide")
        maps = self._known([*_MAPS, *of_odometry[:1]])
        fixed = [f for f in maps if f != robot and self._transforms.connected(f, robot)]
        if not fixed:
            self._warn(f"no pose of {robot!r}")
        return robot, fixed[0] if fixed else None

    def _known(self, names: Iterable[str]) -> list[str]:
        """Frames of the bag with these names, with or without a prefix."""
        frames = self._transforms.frames
        return [f for called in names for f in frames if called in {f, _last(f)}]

    def _twist(self, robot: str, fixed: str | None, time: float) -> Floats:
        times = self._twists[:, 0]
        of_robot = self._frames is not None and robot in {*_ROBOTS, self._frames[2]}
        if of_robot and len(times) and np.min(np.abs(times - time)) <= _STALE:
            return np.array([np.interp(time, times, self._twists[:, k]) for k in (1, 2, 3)])
        if fixed is None:
            return np.zeros(3)
        if self._transforms.extrapolation(fixed, robot, time) > _STALE:
            self._warn(f"no pose of {robot!r} near {time:.3f} s: the nearest one is used")
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


def _stream(frame: str) -> str:
    """Stream of the transforms to a frame."""
    return f"tf to {frame!r}"


def _last(frame: str) -> str:
    return frame.rpartition("/")[2]
