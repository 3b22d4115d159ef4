"""Bags of ROS 1 and ROS 2 as sensor recordings."""

from __future__ import annotations

import heapq
import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import RecordingError
from cohelm.geometry import compose, transform
from cohelm.messages import Observation, PointCloud, Scan
from cohelm.recordings.api import Frame, Labels, far_points_problem
from cohelm.recordings.bags import ros_messages as ros
from cohelm.recordings.bags.records import BagMessage
from cohelm.recordings.bags.sensor_poses import POSE_TYPES, SensorPose, SensorPoses

Reader = Callable[[list[RecordingError]], Iterable[BagMessage]]
"""Reads all messages; appends the damage."""

_LABELS = "leg_cluster_positions"
"""Topic of PoseArrays with labels of the next scan."""

_MAX_DISORDER = 0.5
"""Maximum disorder of readings of several sensors, s."""

_MAX_WARNINGS = 100


class BagRecording:
    """Bag of scans and clouds, one frame each, with the robot's pose from tf and odometry.

    The time of a reading is that of its header, or of its reception where the header has none.
    ``frames`` counts the readings; unreadable ones are skipped with a warning. Opening reads the
    bag once, for tf and odometry; iterating reads it again.

    Args:
        path: The bag, for messages.
        read: Reads it.
        version: ROS version.
        topic: Topic to read; None: all scans and clouds.

    Raises:
        RecordingError: if there is no scan or cloud.
    """

    def __init__(self, path: Path, read: Reader, version: int, topic: str | None) -> None:
        self.name = path.name
        self.warnings: list[str] = []
        self._path = path
        self._read = read
        self._decoder = ros.Decoder(version)
        self._poses = SensorPoses()
        damage: list[RecordingError] = []
        counts = self._survey(damage)
        self._topics = self._choose(counts, topic, damage)
        self.frames: int | None = sum(counts[key] for key in counts if key[0] in self._topics)
        self.warnings.extend(map(str, damage))

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
            raise RecordingError("none of its scans and clouds can be read", file=self._path)

    def _survey(self, damage: list[RecordingError]) -> Counter[tuple[str, str]]:
        """Count the messages of each topic and type, and collect tf and odometry."""
        counts: Counter[tuple[str, str]] = Counter()
        for message in self._messages(damage):
            counts[message.topic, message.type] += 1
            if message.type in POSE_TYPES:
                known = self._decode(message)
                if known is not None:
                    self._poses.add(known, message.type, message.topic, message.time)
        self._poses.finish()
        return counts

    def _choose(
        self,
        counts: Counter[tuple[str, str]],
        topic: str | None,
        damage: list[RecordingError],
    ) -> frozenset[str]:
        usable = sorted({name for name, type_ in counts if type_ in {ros.SCAN, ros.CLOUD}})
        if topic is None and usable:
            return frozenset(usable)
        if topic in usable:
            return frozenset({str(topic)})
        if not counts and damage:
            raise damage[0]
        found = ", ".join(f"{name} ({type_.rpartition('/')[2]})" for name, type_ in sorted(counts))
        wanted = "LaserScan or PointCloud2" if topic is None else f"scan or cloud on {topic}"
        held = f"it has {found[:300]}" if found else "it has no messages"
        raise RecordingError(f"has no {wanted}; {held}", file=self._path)

    def _messages(self, damage: list[RecordingError]) -> Iterator[BagMessage]:
        try:
            yield from self._read(damage)
        except OSError as error:
            raise RecordingError(error.strerror or str(error), file=self._path) from None

    def _frames(self) -> Iterator[Frame]:
        """Frames in the order of the bag."""
        labels: Any = None
        for message in self._messages([]):
            if message.type == ros.POSES and message.topic.rpartition("/")[2] == _LABELS:
                labels = self._decode(message)
            elif message.topic in self._topics and message.type in {ros.SCAN, ros.CLOUD}:
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
        time = ros.stamp(reading.header) or message.time
        place = self._poses.at(reading.header.frame_id, time)
        for text in self._poses.warnings:
            self._add_warning(f"{self._path}: {text}")
        scans: tuple[Scan, ...] = ()
        clouds: tuple[PointCloud, ...] = ()
        if message.type == ros.SCAN:
            scans = (ros.scan(reading, time, place.mount),)
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
            return self._decoder.decode(message.data, message.type)
        except ValueError as error:
            self._warn(str(error), message)
            return None

    def _warn(self, problem: str, message: BagMessage) -> None:
        self._report(f"skipped: {problem[:200]}", message)

    def _report(self, problem: str, message: BagMessage) -> None:
        text = f"a message on {message.topic} at {message.time:.3f} s: {problem}"
        self._add_warning(str(RecordingError(text, file=self._path, offset=message.offset)))

    def _add_warning(self, text: str) -> None:
        if len(self.warnings) < _MAX_WARNINGS and text not in self.warnings:
            self.warnings.append(text)


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
