"""Clocks of the stamps in a bag: streams whose stamps come from different clocks are aligned.

A stream is a topic, or the transforms to one frame. A sensor may stamp with the time since it was
switched on, or run minutes behind the computer. The recorder notes the time of reception of every
message with its one clock, which shows the difference.
"""

from __future__ import annotations

import array
from typing import NamedTuple

import numpy as np

_SAME = 2.0
"""Maximum difference between stamps of one clock, s: they are older than their reception."""
_STEADY = 0.5
"""Maximum median deviation of stamps from their reception, s; else a recorder made these times."""
_MAX_NAMES = 3


class _Offset(NamedTuple):
    """Stamps of a stream minus their times of reception."""

    stream: str
    median: float
    """s."""
    steady: bool


class Alignment(NamedTuple):
    """Times of all messages on one clock, that of the bag."""

    shifts: dict[str, float]
    """Stamps of each stream on another clock, minus those of the bag's clock, s."""
    reception: float
    """Stamps of the bag's clock minus times of reception, s; 0 without stamps."""
    descriptions: tuple[str, ...]

    def time(self, stream: str, stamp: float, received: float) -> float:
        """Time of a message, s; that of its reception where its stamp is 0, which is none."""
        return stamp - self.shifts.get(stream, 0.0) if stamp else received + self.reception


class StampClocks:
    """Stamps and times of reception in a bag."""

    def __init__(self) -> None:
        self._offsets: dict[str, array.array[float]] = {}
        self._newest: dict[str, float] = {}

    def add(self, stream: str, stamp: float, received: float) -> None:
        """Add a message; a stamp that is repeated, as of a standing transform, counts once."""
        if stamp and self._newest.get(stream) != stamp:
            self._newest[stream] = stamp
            self._offsets.setdefault(stream, array.array("d")).append(stamp - received)

    def alignment(self) -> Alignment:
        """Align streams whose times of reception are steady to the clock closest to reception."""
        streams = sorted(map(_offset, self._offsets, self._offsets.values()), key=_distance)
        kept = next((stream for stream in streams if stream.steady), None)
        if kept is None:
            return Alignment({}, 0.0, ())
        away = [stream for stream in streams if abs(stream.median - kept.median) > _SAME]
        groups: list[list[_Offset]] = []
        for stream in sorted(away, key=lambda stream: (stream.steady, stream.median)):
            last = groups[-1][-1] if groups else None
            if last and last.steady == stream.steady and stream.median - last.median <= _SAME:
                groups[-1].append(stream)
            else:
                groups.append([stream])
        shifts = {stream.stream: stream.median - kept.median for stream in away if stream.steady}
        texts = tuple(_description(group, kept) for group in groups)
        return Alignment(shifts, kept.median, texts)


def _offset(stream: str, offsets: array.array[float]) -> _Offset:
    each = np.array(offsets)
    median = float(np.median(each))
    return _Offset(stream, median, bool(np.median(np.abs(each - median)) <= _STEADY))


def _distance(stream: _Offset) -> float:
    return abs(stream.median)


def _description(group: list[_Offset], kept: _Offset) -> str:
    names = ", ".join(stream.stream for stream in group[:_MAX_NAMES])
    more = ", …" if len(group) > _MAX_NAMES else ""
    ahead = group[0].median - kept.median
    side = "ahead of" if ahead > 0.0 else "behind"
    done = "they are moved by that, as their times of reception agree"
    if not group[0].steady:
        done = "their times of reception vary, so they are used as they are"
    return f"stamps of {names}{more} are {abs(ahead):.1f} s {side} those of {kept.stream}: {done}"
