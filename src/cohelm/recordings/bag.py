"""Bags of ROS 1 and ROS 2 as recordings."""

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
from cohelm.messages import Observation
from cohelm.recordings import ros_messages as ros
from cohelm.recordings.api import Frame, Labels
from cohelm.recordings.records import Message
from cohelm.recordings.whereabouts import KINDS, Place, Whereabouts

Reader = Callable[[list[RecordingError]], Iterable[Message]]
"""Reads all messages once more; takes what cannot be read."""

_LABELS = "leg_cluster_positions"
"""A topic of PoseArrays, each with the labels of the scan that comes next in the bag."""

_WAIT = 0.5
"""By how much readings may come out of order, as those of several sensors do, s."""


_MOST_WARNINGS = 100


class BagRecording:
    """A bag of scans and clouds, each a frame, with the robot's pose from tf and odometry.

    A reading's time is that of its header, or that of its reception where the header has none.
    ``frames`` counts the readings; one that turns out to be unreadable is left out and told in
    ``warnings``. Opening reads the bag once, to note tf and odometry; iterating reads it again.

    Args:
        path: of the bag, for messages.
        read: reads it.
        version: of ROS.
        topic: the one to take; None: all scans and clouds.

    Raises:
        RecordingError: if there is nothing to take.
    """

    def __init__(self, path: Path, read: Reader, version: int, topic: str | None) -> None:
        self.name = path.name
        self.warnings: list[str] = []
        self._path = path
        self._read = read
        self._decoder = ros.Decoder(version)
        self._places = Whereabouts()
        damage: list[RecordingError] = []
        counts = self._survey(damage)
        self._topics = self._choose(counts, topic, damage)
        self.frames: int | None = sum(counts[key] for key in counts if key[0] in self._topics)
        self.warnings.extend(map(str, damage))

    def __iter__(self) -> Iterator[Frame]:
        """The frames in the order of time, from the first one on.

        Raises:
            RecordingError: if no reading can be understood.
        """
        seen = False
        for frame in _in_order(self._frames()):
            seen = True
            yield frame
        if not seen:
            raise RecordingError("none of its scans and clouds can be read", file=self._path)

    def _survey(self, damage: list[RecordingError]) -> Counter[tuple[str, str]]:
        """How many messages there are of each topic and type; places are noted."""
        counts: Counter[tuple[str, str]] = Counter()
        for message in self._messages(damage):
            counts[message.topic, message.type] += 1
            if message.type in KINDS:
                known = self._decode(message)
                if known is not None:
                    self._places.note(known, message.type, message.topic, message.time)
        self._places.settle()
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
        there = ", ".join(f"{name} ({type_.rpartition('/')[2]})" for name, type_ in sorted(counts))
        wanted = "LaserScan or PointCloud2" if topic is None else f"scan or cloud on {topic}"
        held = f"it has {there[:300]}" if there else "it has no messages"
        raise RecordingError(f"holds no {wanted}; {held}", file=self._path)

    def _messages(self, damage: list[RecordingError]) -> Iterator[Message]:
        try:
            yield from self._read(damage)
        except OSError as error:
            raise RecordingError(error.strerror or str(error), file=self._path) from None

    def _frames(self) -> Iterator[Frame]:
        """As they come in the bag."""
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

    def _frame(self, reading: Any, message: Message, labels: Any) -> Frame:
        time = ros.stamp(reading.header) or message.time
        place = self._places.place(reading.header.frame_id, time)
        for text in self._places.warnings:
            self._note(f"{self._path}: {text}")
        is_scan = message.type == ros.SCAN
        return Frame(
            observation=Observation(
                time=time,
                pose=place.pose,
                pose_time=time,
                twist=place.twist,
                twist_time=time,
                scans=(ros.scan(reading, time, place.mount),) if is_scan else (),
                clouds=() if is_scan else (ros.cloud(reading, time, place.mount),),
            ),
            labels=None if labels is None else _labels(labels, time, place),
            posed=place.told,
        )

    def _decode(self, message: Message) -> Any:
        """The message; None where it makes no sense, which is told."""
        try:
            return self._decoder.decode(message.data, message.type)
        except ValueError as error:
            self._warn(str(error), message)
            return None

    def _warn(self, problem: str, message: Message) -> None:
        text = f"a message on {message.topic} at {message.time:.3f} s is left out: {problem[:200]}"
        self._note(str(RecordingError(text, file=self._path, offset=message.offset)))

    def _note(self, text: str) -> None:
        if len(self.warnings) < _MOST_WARNINGS and text not in self.warnings:
            self.warnings.append(text)


def _labels(poses: Any, time: float, place: Place) -> Labels:
    """Places that are told in the sensor's frame."""
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
    """In the order of time, unless the clock itself runs back."""
    waiting: list[tuple[float, int, Frame]] = []
    newest = -np.inf
    for number, frame in zip(itertools.count(), frames, strict=False):
        time = frame.observation.time
        if time < newest - _WAIT:
            while waiting:
                yield heapq.heappop(waiting)[2]
            newest = time
        newest = max(newest, time)
        heapq.heappush(waiting, (time, number, frame))
        while waiting[0][0] <= newest - _WAIT:
            yield heapq.heappop(waiting)[2]
    while waiting:
        yield heapq.heappop(waiting)[2]
