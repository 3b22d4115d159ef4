"""Inputs of a ROS 2 robot: messages go in as they come, one observation comes out in each step.

Transforms between frames are the latest that a localiser, odometry and the robot's description say.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import Observation, People, PointCloud, RiderCommand, Scan
from cohelm.platforms import LeadingReadings
from cohelm.recordings.bags import ros_messages as ros
from cohelm.recordings.transforms import MAX_COORDINATE, matrix, name, planar
from cohelm.ros2.clocks import Clock
from cohelm.ros2.conversions import (
    Moving,
    is_level,
    mount_of,
    moving,
    people_of,
    stick_of,
    twist_at_base,
)
from cohelm.ros2.parameters import Ros2Parameters


@dataclass(frozen=True, slots=True)
class Link:
    """Transform from a frame to its parent."""

    parent: str
    X_PC: Floats
    """(4, 4) pose of the child in the parent."""
    time: float
    """Stamp, s; −inf: static."""
    arrival: float
    """Time at which it arrived, s."""


class FrameTree:
    """Latest link of every frame; memory grows with the number of frames only."""

    def __init__(self) -> None:
        self._links: dict[str, Link] = {}

    def add(
        self,
        parent: str,
        child: str,
        transform: tuple[float, ...],
        *,
        time: float,
        arrival: float,
    ) -> bool:
        """Add the pose (x, y, z, q_x, q_y, q_z, q_w) of ``child`` in ``parent``.

        Returns:
            False if it was ignored: a number that is not finite, a zero quaternion, or a cycle.
        """
        parent, child = name(parent), name(child)
        finite = all(math.isfinite(n) and abs(n) < MAX_COORDINATE for n in transform)
        if not finite or math.isnan(time) or not 1e-3 < math.hypot(*transform[3:]) < 1e3:
            return False
        if child in {parent, *self._ancestors(parent)}:
            return False
        self._links[child] = Link(parent, matrix(transform), time, arrival)
        return True

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames."""
        parents = [link.parent for link in self._links.values()]
        return tuple(dict.fromkeys([*self._links, *parents]))

    def link(self, child: str) -> Link | None:
        """Return the latest link of a frame; None: it has no parent."""
        return self._links.get(name(child))

    def connected(self, a: str, b: str) -> bool:
        """Check that a chain of transforms connects two frames."""
        roots = [[name(each), *self._ancestors(name(each))][-1] for each in (a, b)]
        return roots[0] == roots[1]

    def pose(self, a: str, b: str) -> Floats | None:
        """Return X_AB (4, 4) from the latest links; None: the frames are not connected."""
        if name(a) == name(b):
            return np.eye(4)
        if not self.connected(a, b):
            return None
        out: Floats = np.linalg.inv(self._from_root(name(a))) @ self._from_root(name(b))
        return out

    def _from_root(self, frame: str) -> Floats:
        total = np.eye(4)
        for link in self._chain(frame):
            total = link.X_PC @ total
        return total

    def _chain(self, frame: str) -> Iterator[Link]:
        while frame in self._links:
            link = self._links[frame]
            yield link
            frame = link.parent

    def _ancestors(self, frame: str) -> list[str]:
        return [link.parent for link in self._chain(frame)]


NEVER = -10.0
"""Time of an input that never came, s: older than every limit."""
MAX_READINGS = 16
"""Maximum number of scans, and of clouds, kept until the next observation."""
_HISTORY = 50
"""Messages of a topic that count for rate and delay."""


@dataclass(slots=True)
class TopicStatistics:
    """Messages of one topic so far."""

    arrivals: deque[float]
    """Newest arrival times, s."""
    delays: deque[float]
    """Time from the stamp to the arrival of each, s; NaN without a stamp."""
    frame: str = ""
    """Frame of the newest message."""
    count: int = 0
    problem: str = ""
    """Reason why the newest message cannot be used; empty: it can."""

    @property
    def rate(self) -> float:
        """Messages per second; 0 below two messages."""
        span = self.arrivals[-1] - self.arrivals[0] if len(self.arrivals) > 1 else 0.0
        return (len(self.arrivals) - 1) / span if span > 0.0 else 0.0

    @property
    def delay(self) -> float:
        """Median delay, s; NaN without stamps."""
        known = [each for each in self.delays if math.isfinite(each)]
        return float(np.median(known)) if known else math.nan


class Inputs:
    """Newest inputs; ``take_…`` run in the node's thread, the others in any thread.

    Args:
        parameters: Frames and limits.
        clock: Clock of the platform.
    """

    def __init__(self, parameters: Ros2Parameters, clock: Clock) -> None:
        self._parameters, self.clock = parameters, clock
        self._lock = threading.Lock()
        self.frames = FrameTree()
        self._moving: Moving | None = None
        self._rider: RiderCommand | None = None
        self._people: People | None = None
        self._names: dict[str, int] = {}
        self._read_at: dict[str, float] = {}
        if parameters.page_sticks:  # a stick that never comes is a stick that is lost
            self._rider = RiderCommand(heartbeat=NEVER, deflection=np.zeros(2))
        self._scans: deque[Scan] = deque(maxlen=MAX_READINGS)
        self._clouds: deque[PointCloud] = deque(maxlen=MAX_READINGS)
        self.leading = LeadingReadings()
        """Arrivals on :attr:`Ros2Parameters.leading`."""
        self.last_scan: dict[str, Scan] = {}
        """Newest scan of each topic."""
        self.topics: dict[str, TopicStatistics] = {}
        """Statistics by topic."""

    def take_transforms(self, message: Any, *, static: bool) -> None:
        """Take a TFMessage."""
        now = self.clock.now()
        topic = "/tf_static" if static else "/tf"
        with self._lock:
            for each in message.transforms:
                time = -math.inf if static else self.clock.of(ros.stamp(each.header))
                frames = each.header.frame_id, each.child_frame_id
                if not math.isnan(time):  # the robot's clock has begun
                    self.frames.add(*frames, ros.transform(each.transform), time=time, arrival=now)
                # Delays of a localiser may be negative: it stamps its transform into the future.
                self._count(topic, now, math.nan if static else now - time, frames[1])

    def take_odometry(self, message: Any) -> None:
        """Take an Odometry; empty names of frames stand for ``frames.odom`` and ``frames.base``."""
        now, topic = self.clock.now(), self._parameters.odometry
        frames = self._parameters.frames
        with self._lock:
            try:
                found = moving(message)
            except ValueError as error:
                self._count(topic, now, math.nan, "", problem=str(error))
                return
            time = self.clock.of(found.time)
            self._count(topic, now, now - time, found.child)
            if math.isfinite(time):
                self._moving = found._replace(
                    time=time, frame=found.frame or frames.odom, child=found.child or frames.base
                )

    def take_scan(self, topic: str, message: Any) -> None:
        """Take a LaserScan of a sensor whose mount the transforms tell."""
        now = self.clock.now()
        time, frame = self.clock.of(ros.stamp(message.header)), name(message.header.frame_id)
        with self._lock:
            mount, problem = self._mount(frame)
            if mount is not None and not is_level(mount):
                mount, problem = None, f"'{frame}' is tilted: a planar scanner must be level"
            scan = None
            if mount is not None and math.isfinite(time):
                try:
                    scan = ros.scan(message, time, mount)
                except ValueError as error:
                    problem = str(error)
            self._count(topic, now, now - time, frame, problem=problem)
            if scan is not None:
                self._scans.append(scan)
                self._read(topic, scan.time)
                self.last_scan[topic] = scan

    def take_stick(self, message: Any) -> None:
        """Take a Joy of a stick that is a device of the page that drives."""
        parameters, now = self._parameters.stick, self.clock.now()
        if parameters is None:
            return
        position, problem = None, ""
        try:
            position = stick_of(message, parameters)
        except ValueError as error:
            problem = str(error)
        with self._lock:
            self._count(parameters.topic, now, math.nan, "", problem=problem)
            if position is not None:
                deflection = np.array([position.forward, position.left])
                self._rider = RiderCommand(heartbeat=now, deflection=deflection)

    def take_cloud(self, topic: str, message: Any) -> None:
        """Take a PointCloud2 of a sensor whose mount the transforms tell."""
        now = self.clock.now()
        time, frame = self.clock.of(ros.stamp(message.header)), name(message.header.frame_id)
        with self._lock:
            mount, problem = self._mount(frame)
        cloud = None
        if mount is not None and math.isfinite(time):
            try:
                cloud, far = ros.cloud(message, time, mount)
                problem = f"{far} points are too far away for any sensor" if far else problem
            except ValueError as error:
                problem = str(error)
        with self._lock:
            self._count(topic, now, now - time, frame, problem=problem)
            if cloud is not None:
                self._clouds.append(cloud)
                self._read(topic, cloud.time)

    def take_people(self, message: Any) -> None:
        """Take a People of another node."""
        topic = self._parameters.people
        now, frame = self.clock.now(), name(message.header.frame_id)
        time, goal = self.clock.of(ros.stamp(message.header)), self._parameters.frames
        if topic is None:
            return
        with self._lock:
            X_MF, problem = self.frames.pose(goal.map or goal.odom, frame), ""
            if X_MF is None:
                problem = f"no transform from '{goal.map or goal.odom}' to '{frame}'"
            elif math.isfinite(time):
                try:
                    self._people = people_of(message, time, X_MF, self._names)
                except ValueError as error:
                    problem = str(error)
            self._count(topic, now, now - time, frame, problem=problem)

    def observation(self) -> Observation:
        """Return the newest pose and twist, and all readings since the last call.

        What never came has the time −10 s, since a time must be a number.
        """
        with self._lock:
            now = self.clock.now()
            pose, pose_time = self._pose()
            twist, twist_time = self._twist()
            scans, clouds = tuple(self._scans), tuple(self._clouds)
            self._scans.clear()
            self._clouds.clear()
            self.leading.taken()
            rider, people = self._rider, self._people
            if self._parameters.people is not None:
                people, scans, clouds = self._with_people(now, people, scans, clouds)
        return Observation(
            time=now,
            pose=pose,
            pose_time=max(pose_time, NEVER),
            twist=twist,
            twist_time=max(twist_time, NEVER),
            scans=scans,
            clouds=clouds,
            rider=rider,
            people=people,
        )

    def _with_people(
        self,
        now: float,
        people: People | None,
        scans: tuple[Scan, ...],
        clouds: tuple[PointCloud, ...],
    ) -> tuple[People | None, tuple[Scan, ...], tuple[PointCloud, ...]]:
        """People and readings for an observation.

        With people the safety gate does not watch the scanners, and without them it knows nobody.
        So old people count as a lost sensor, whose readings are withheld until the gate stops; and
        where a scanner is old, people are withheld, and the gate watches the scanners again.
        """
        limit = self._parameters.limits.people
        if people is None or not now - people.time <= limit:
            return None, (), ()
        topics = (*self._parameters.scans, *self._parameters.clouds)
        read = all(now - self._read_at.get(each, -math.inf) <= limit for each in topics)
        return (people if read else None), scans, clouds

    @property
    def odometry_time(self) -> float:
        """Stamp of the newest odometry, s; −inf: none has come."""
        return self._moving.time if self._moving is not None else -math.inf

    @property
    def odometry_problem(self) -> str:
        """Reason why the newest odometry's frames are of no use; empty: they are, or none came."""
        found, frames = self._moving, self._parameters.frames
        if found is None:
            return ""
        for a, b in ((frames.odom, found.frame), (found.child, frames.base)):
            if self.frames.pose(a, b) is None:
                return f"no transform from '{name(a)}' to '{name(b)}'"
        return ""

    def localised(self) -> tuple[Floats, float] | None:
        """Return X_MO (4, 4) and its age, s; None: the localiser's transform never came."""
        frames = self._parameters.frames
        if frames.map is None:
            return np.eye(4), 0.0
        link, pose = self.frames.link(frames.odom), self.frames.pose(frames.map, frames.odom)
        if link is None or pose is None:
            return None
        age = 0.0 if link.time == -math.inf else self.clock.now() - link.arrival
        return pose, age

    def _pose(self) -> tuple[Floats, float]:
        """X_MR (3,) and its time, s."""
        found, localised, links = self._moving, self.localised(), self._odometry_links()
        if found is None or localised is None or links is None:
            return np.zeros(3), -math.inf
        X_MO, age = localised
        # Old localisation makes the pose old; a recent one has the age of the odometry.
        late = max(age - self._parameters.limits.localiser, 0.0)
        lost = -math.inf if late > 0.0 else found.time
        X_OF, X_CB = links
        return planar(X_MO @ X_OF @ found.X_OC @ X_CB), lost

    def _twist(self) -> tuple[Floats, float]:
        found, links = self._moving, self._odometry_links()
        if found is None or links is None:
            return np.zeros(3), -math.inf
        return twist_at_base(found.twist, links[1]), found.time

    def _odometry_links(self) -> tuple[Floats, Floats] | None:
        """X_OF of the odometry's frame and X_CB of the base in its child frame, both (4, 4).

        None: one is not connected, or no odometry has come.
        """
        found, frames = self._moving, self._parameters.frames
        if found is None:
            return None
        X_OF, X_CB = (
            self.frames.pose(frames.odom, found.frame),
            self.frames.pose(found.child, frames.base),
        )
        return None if X_OF is None or X_CB is None else (X_OF, X_CB)

    def _mount(self, frame: str) -> tuple[Floats | None, str]:
        """Mount (6,) of a sensor's frame, or the reason why it is not known."""
        base = self._parameters.frames.base
        pose = self.frames.pose(base, frame)
        if pose is None:
            return None, f"no transform from '{base}' to '{frame}'"
        return mount_of(pose), ""

    def _read(self, topic: str, time: float) -> None:
        """Note a reading that can be observed now."""
        self._read_at[topic] = time
        if topic == self._parameters.leading:
            self.leading.arrived()

    def _count(
        self, topic: str, now: float, delay: float, frame: str, *, problem: str = ""
    ) -> None:
        found = self.topics.get(topic)
        if found is None:
            found = TopicStatistics(deque(maxlen=_HISTORY), deque(maxlen=_HISTORY))
            self.topics[topic] = found
        found.arrivals.append(now)
        found.delays.append(delay)
        found.frame, found.problem = frame, problem
        found.count += 1
