"""Read a recorded ride, exactly to the bit, as far as the file is sound."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from cohelm.errors import RecordingError
from cohelm.recordings.bags.files import MCAP, BagMessage, read_bag
from cohelm.recordings.bags.ros_messages import decode
from cohelm.recordings.rides.exact import unpack
from cohelm.recordings.rides.ride import FORMAT, RIDE_TOPIC, TICK_TOPIC, RideFacts, RideTick

_T = TypeVar("_T")


class RecordedRide:
    """Ride in an MCAP file that :class:`~.recorder.RideRecorder` has written.

    Args:
        file: The MCAP file.

    Raises:
        RecordingError: if it is not an MCAP file, holds no ride of cohelm, or one of an unknown
            format.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self.warnings: list[str] = []
        """One line for everything that could not be read; grows while reading."""
        _check_kind(file)
        self.facts = self._facts()
        """Parts and parameters of the navigator."""

    def __iter__(self) -> Iterator[RideTick]:
        """Iterate over the ticks, each with its request, up to the first gap.

        Ticks after a gap are useless: the navigator's memory would differ.

        Raises:
            RecordingError: if there is no tick at all.
        """
        damage: list[RecordingError] = []
        last: RideTick | None = None
        try:
            for message in read_bag([self.file], damage):
                if message.topic == TICK_TOPIC:
                    last = self._next(message, last)
                    yield last
        except RecordingError as fault:
            if last is None:
                raise
            damage.append(fault)
        if last is None:
            raise damage[0] if damage else RecordingError("holds no tick", file=self.file)
        for each in damage:
            text = f"{each}; read until {last.observation.time:.2f} s"
            if text not in self.warnings:
                self.warnings.append(text)

    def _next(self, message: BagMessage, last: RideTick | None) -> RideTick:
        tick = self._value(message, RideTick)
        due = 0 if last is None else last.number + 1
        if tick.number != due:
            raise self._fault(message, f"ticks {due} to {tick.number - 1} are missing")
        if tick.request is not None:
            return tick
        if last is None:
            raise self._fault(message, "the first tick has no request")
        return replace(tick, request=last.request)

    def _facts(self) -> RideFacts:
        damage: list[RecordingError] = []
        topics: set[str] = set()
        for message in read_bag([self.file], damage):
            if message.topic == RIDE_TOPIC:
                facts = self._value(message, RideFacts)
                if facts.format != FORMAT:
                    problem = f"is of format {facts.format}; this version reads format {FORMAT}"
                    raise RecordingError(problem, file=self.file)
                return facts
            topics.add(message.topic)
        if damage and not topics:
            raise damage[0]
        there = ", ".join(sorted(topics))[:200] or "no messages"
        problem = f"holds no ride of cohelm, which has {RIDE_TOPIC}; it has {there}"
        raise RecordingError(problem, file=self.file)

    def _value(self, message: BagMessage, kind: type[_T]) -> _T:
        try:
            octets: Any = decode(message)
            return unpack(bytes(octets.data), kind)
        except (ValueError, AttributeError) as fault:
            raise self._fault(message, f"a message on {message.topic} {fault}") from None

    def _fault(self, message: BagMessage, problem: str) -> RecordingError:
        return RecordingError(f"at {message.time:.2f} s: {problem}", file=self.file)


def _check_kind(file: Path) -> None:
    try:
        with file.open("rb") as stream:
            start = stream.read(len(MCAP))
    except OSError as cause:
        raise RecordingError(cause.strerror or str(cause), file=file) from None
    if not start:
        raise RecordingError("is empty; record a ride with cohelm run --record", file=file)
    if start != MCAP:
        problem = "is not an MCAP file; record a ride with cohelm run --record"
        raise RecordingError(problem, file=file, offset=0)
