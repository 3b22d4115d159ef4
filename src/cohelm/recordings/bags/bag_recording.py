"""Bags of ROS 1 and ROS 2 as sensor recordings.

Topics of a bag that repeat another one: filtered, throttled or relayed copies of readings.
"""

from __future__ import annotations

import heapq
import itertools
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import RecordingError
from cohelm.geometry import compose, transform
from cohelm.messages import Observation, PointCloud, Scan
from cohelm.recordings.api import Frame, Labels, far_points_problem
from cohelm.recordings.bags import ros_messages as ros
from cohelm.recordings.bags.clocks import StampClocks
from cohelm.recordings.bags.files import BagMessage, read_bag
from cohelm.recordings.bags.sensor_poses import POSE_TYPES, SensorPose, SensorPoses

_SHARED = 0.5
"""Minimum share of a topic's times that the other one has, too."""


@dataclass(slots=True)
class TopicReadings:
    """Scans or clouds on one topic."""

    type: str
    frame: str
    sector: tuple[float, float]
    """First and last direction of a scan, rad."""
    times: set[float] = field(default_factory=set)
    size: int = 0
    """Size of all messages, bytes."""

    @classmethod
    def of(cls, type_: str, reading: Any) -> TopicReadings:
        """Record for the topic of a LaserScan or PointCloud2."""
        ends = (getattr(reading, f"angle_{end}", math.inf) for end in ("min", "max"))
        low, high = sorted(map(float, ends))
        return cls(type_, reading.header.frame_id, (-high if math.isinf(low) else low, high))

    def repeats(self, other: TopicReadings) -> bool:
        """Check that another topic has readings of the same sensor at the same times."""
        return (
            (self.type, self.frame) == (other.type, other.frame)
            and max(self.sector[0], other.sector[0]) < min(self.sector[1], other.sector[1])
            and len(self.times & other.times) >= _SHARED * len(self.times)
        )


def duplicates(sources: Mapping[str, TopicReadings]) -> dict[str, str]:
    """Topics that repeat another one, with that one, which has the most messages and bytes."""
    kept: list[str] = []
    found: dict[str, str] = {}
    order = {topic: (-len(s.times), -s.size, len(topic), topic) for topic, s in sources.items()}
    for topic in sorted(sources, key=order.__getitem__):
        whole = next((name for name in kept if sources[topic].repeats(sources[name])), None)
        if whole is None:
            kept.append(topic)
        else:
            found[topic] = whole
    return found


_LABELS = "leg_cluster_positions"
"""Topic of PoseArrays with labels of the next scan."""

_MAX_DISORDER = 0.5
"""Maximum disorder of readings of several sensors, s."""

_MAX_WARNINGS = 100
_REASONS = 5
"""Maximum number of reasons in an error."""
_READINGS = frozenset({ros.SCAN, ros.CLOUD})
_SENSORS = ("LaserScan", "PointCloud")
"""Parts of the names of types of scans and clouds: those that are not read are reported."""
_WITH_DIGITS = re.compile(r"\w*\d\w*")

_Topic = tuple[str, str, str]
"""Name, type and encoding."""


class BagRecording:
    """Bag of scans and clouds, one frame each, with the robot's pose from tf and odometry.

    The time of a reading is that of its header, or of its reception where the header has none;
    stamps of different clocks are aligned. ``frames`` counts the readings; unreadable ones are
    skipped with a warning. Opening reads the bag once, for tf, odometry and stamps; iterating reads
    it again.

    Args:
        path: The recording, for messages.
        files: Its parts in their order.
        topic: Topic to read; None: all scans and clouds.

    Raises:
        RecordingError: if there is no scan or cloud.
    """

    def __init__(self, path: Path, files: Sequence[Path], topic: str | None) -> None:
        self.name = path.name
        self.warnings: list[str] = []
        self._path = path
        self._files = files
        self._reports: dict[tuple[str, str], str] = {}
        self._clocks = StampClocks()
        self._poses = SensorPoses(self._clocks)
        self._damage: list[RecordingError] = []
        self._sources: dict[str, TopicReadings] = {}
        counts = self._survey()
        if self._damage and not counts:
            raise self._damage[0]
        self._topics = self._choose(counts, topic)
        self.frames: int | None = sum(counts[key] for key in counts if key[0] in self._topics)
        self.warnings.extend(map(str, self._damage))
        self._clock = self._clocks.alignment()
        self._poses.finish(self._clock)
        self.warnings.extend(f"{path}: {difference}" for difference in self._clock.descriptions)

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames in the order of time.

        Raises:
            RecordingError: if no reading can be decoded.
        """
        seen = False
        newest = -np.inf
        for frame in _in_order(self._frames()):
            seen = True
            time = frame.observation.time
            if time < newest:
                text = f"the time goes back from {newest:.3f} to {time:.3f} s"
                self._add_warning(str(RecordingError(text, file=self._path)))
            newest = time
            yield frame
        if not seen:
            raise self._error("none of its scans and clouds can be read")

    def _survey(self) -> Counter[_Topic]:
        """Count the messages of each topic, and collect poses, stamps and sources."""
        counts: Counter[_Topic] = Counter()
        for message in read_bag(self._files, self._damage):
            counts[message.topic, message.type, message.encoding] += 1
            if message.type in POSE_TYPES:
                known = self._decode(message)
                if known is not None:
                    self._poses.add(known, message.type, message.topic, message.time)
            elif message.type in _READINGS:
                self._add_source(message)
        return counts

    def _add_source(self, message: BagMessage) -> None:
        try:
            reading = ros.decode(message)
        except ValueError:  # reported where its frame is missing
            return
        stamp = ros.stamp(reading.header)
        self._clocks.add(message.topic, stamp, message.time)
        source = self._sources.setdefault(message.topic, TopicReadings.of(message.type, reading))
        source.times.add(stamp or message.time)
        source.size += len(message.data)

    def _choose(self, counts: Counter[_Topic], topic: str | None) -> frozenset[str]:
        usable = {name for name, type_, _ in counts if type_ in _READINGS}
        if topic is None and usable:
            repeated = duplicates(self._sources)
            for name, whole in sorted(repeated.items()):
                text = f"{name} repeats {whole}, with the same frame and times: {whole} is read"
                self._add_warning(f"{self._path}: {text}")
            others = [each for each in counts if each[0] not in usable and _sensor(each[1])]
            if others:
                self._add_warning(f"{self._path}: not read: {_listed(others)}")
            return frozenset(usable - repeated.keys())
        if topic in usable:
            return frozenset({str(topic)})
        wanted = "LaserScan or PointCloud2" if topic is None else f"scan or cloud on {topic}"
        held = f"it has {_listed(counts) or 'no messages'}"
        raise self._error(f"has no {wanted}; {held}")

    def _error(self, problem: str) -> RecordingError:
        """Error with the first reasons."""
        own = [d.problem if d.file == self._path else str(d) for d in self._damage]
        reasons = [*own, *self._reports.values()][:_REASONS]
        return RecordingError("; ".join([problem, *reasons]), file=self._path)

    def _frames(self) -> Iterator[Frame]:
        """Frames in the order of the bag."""
        labels: Any = None
        for message in read_bag(self._files, []):
            if message.type == ros.POSES and message.topic.rpartition("/")[2] == _LABELS:
                labels = self._decode(message)
            elif message.topic in self._topics and message.type in _READINGS:
                reading = self._decode(message)
                if reading is None:
                    continue
                try:
                    frame = self._frame(reading, message, labels)
                except ValueError as error:
                    self._warn(str(error), message)
                    continue
                labels = None
                yield frame

    def _frame(self, reading: Any, message: BagMessage, labels: Any) -> Frame:
        time = self._clock.time(message.topic, ros.stamp(reading.header), message.time)
        place = self._poses.at(reading.header.frame_id, time)
        for text in self._poses.warnings:
            self._add_warning(f"{self._path}: {text}")
        scans: tuple[Scan, ...] = ()
        clouds: tuple[PointCloud, ...] = ()
        if message.type == ros.SCAN:
            scans = (ros.scan(reading, time, place.mount),)
            if problem := ros.angle_problem(reading):
                self._report(problem, message)
        else:
            cloud, far = ros.cloud(reading, time, place.mount)
            clouds = (cloud,)
            if far:
                self._report(far_points_problem(far, len(cloud.points)), message)
        return Frame(
            observation=Observation(
                time=time,
                pose=place.pose,
                pose_time=time,
                twist=place.twist,
                twist_time=time,
                scans=scans,
                clouds=clouds,
            ),
            labels=None if labels is None else _labels(labels, time, place),
            posed=place.known,
            unplaced="" if place.known or place.mounted else reading.header.frame_id,
        )

    def _decode(self, message: BagMessage) -> Any:
        """Decode a message; None, with a warning, where that fails."""
        try:
            return ros.decode(message)
        except ValueError as error:
            self._warn(str(error), message)
            return None

    def _warn(self, problem: str, message: BagMessage) -> None:
        self._report(f"skipped: {problem[:200]}", message)

    def _report(self, problem: str, message: BagMessage) -> None:
        """Warn of the first message of a topic with a problem, numbers in it apart."""
        key = message.topic, _WITH_DIGITS.sub("", problem)
        if key not in self._reports:
            text = f"{message.topic}, first at {message.time:.3f} s: {problem}"
            self._reports[key] = text
            self._add_warning(f"{self._path}: {text}")

    def _add_warning(self, text: str) -> None:
        if len(self.warnings) >= _MAX_WARNINGS and text not in self.warnings:
            text = f"{self._path}: further warnings are left out"
        if text not in self.warnings:
            self.warnings.append(text)


def _sensor(type_: str) -> bool:
    """Check that a type is of scans or clouds, also of one that is not read."""
    return any(part in type_ for part in _SENSORS)


def _listed(topics: Iterable[_Topic]) -> str:
    """Topics with their types, and their encodings where those are not read."""
    kinds = []
    for name, type_, encoding in sorted(topics):
        kind = type_.rpartition("/")[2] or "no type"
        kinds.append(f"{name} ({kind}{'' if encoding in ros.ENCODINGS else f', {encoding}'})")
    return ", ".join(kinds)[:300]


def _labels(poses: Any, time: float, place: SensorPose) -> Labels:
    """Labels from positions in the sensor's frame."""
    seen = np.array([(p.position.x, p.position.y) for p in poses.poses]).reshape(-1, 2)
    seen = seen[np.isfinite(seen).all(axis=1)]
    X_MS: Floats = compose(place.pose, place.mount[[0, 1, 5]])
    return Labels(
        time=time,
        position=transform(X_MS, seen),
        id=np.full(len(seen), -1),
        visible=np.ones(len(seen)),
    )


def _in_order(frames: Iterable[Frame]) -> Iterator[Frame]:
    """Sort frames by time, unless the clock itself jumps back."""
    waiting: list[tuple[float, int, Frame]] = []
    newest = -np.inf
    for number, frame in zip(itertools.count(), frames, strict=False):
        time = frame.observation.time
        if time < newest - _MAX_DISORDER:
            while waiting:
                yield heapq.heappop(waiting)[2]
            newest = time
        newest = max(newest, time)
        heapq.heappush(waiting, (time, number, frame))
        while waiting[0][0] <= newest - _MAX_DISORDER:
            yield heapq.heappop(waiting)[2]
    while waiting:
        yield heapq.heappop(waiting)[2]
