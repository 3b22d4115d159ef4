"""Where the sensors of a recording were that does not say so: found from what they saw."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from enum import StrEnum

from cohelm.arrays import value
from cohelm.geometry import transform
from cohelm.messages import Observation
from cohelm.perception import Matching, Way, follow, outline_of
from cohelm.recordings import Frame


class Whence(StrEnum):
    """How it is known where the robot was."""

    TOLD = "as the recording says"
    FOUND = "found from its readings"
    ASSUMED = "taken as at rest"


@value
class Placed:
    """A frame, and how it is known where it was taken."""

    frame: Frame
    whence: Whence
    way: Way | None = None
    """The way so far, where it was found."""


class OwnWay:
    """Puts poses and twists into frames that have none, and moves their labels along.

    Several sensors of which nobody says how they are mounted have a way each.

    Args:
        at_rest: take them as at rest instead.
    """

    def __init__(self, *, at_rest: bool = False) -> None:
        self._at_rest = at_rest
        self._ways: dict[Hashable, Way] = {}

    @property
    def parts(self) -> int:
        """How often a way began anew, so that nobody knows where its next part lies."""
        return sum(way.part for way in self._ways.values())

    def __call__(self, frame: Frame) -> Placed:
        """The next frame with its pose."""
        if frame.posed:
            return Placed(frame=frame, whence=Whence.TOLD)
        if self._at_rest:
            return Placed(frame=frame, whence=Whence.ASSUMED)
        observation, sensor = frame.observation, _sensor(frame.observation)
        way = follow(self._ways.get(sensor), outline_of(observation), observation.time)
        self._ways[sensor] = way
        labels = frame.labels
        if labels is not None:
            labels = replace(labels, position=transform(way.pose, labels.position))
        placed = replace(observation, pose=way.pose, twist=way.twist)
        return Placed(
            frame=replace(frame, observation=placed, labels=labels), whence=Whence.FOUND, way=way
        )


class Travelled:
    """What the way of a recording comes to."""

    def __init__(self) -> None:
        self.whence = Whence.TOLD
        """How it is known; of a recording of which only a part is told, what the rest is."""
        self.length = 0.0
        """Of what was found, m."""
        self.anew = 0
        """Frames that fitted nothing before, so that all began anew."""
        self.unsure = 0
        """Frames that said nothing of one direction at least, or fitted nothing for a moment."""

    def add(self, whence: Whence, way: Way | None) -> None:
        """One more frame."""
        if whence is not Whence.TOLD:
            self.whence = whence
        if way is None:
            return
        self.anew += way.matching is Matching.ANEW
        self.unsure += way.matching in {Matching.PARTLY, Matching.HELD}
        self.length = way.length

    def __str__(self) -> str:
        """In words."""
        if self.whence is not Whence.FOUND:
            return self.whence.value
        parts = [f"{self.length:.1f} m, {self.whence.value}" if self.length else "at rest"]
        parts += [f"begun anew {self.anew} times"] * (self.anew > 0)
        parts += [f"unsure in {self.unsure} frames"] * (self.unsure > 0)
        return ", ".join(parts)


def _sensor(observation: Observation) -> Hashable:
    """What tells the sensors apart whose readings these are."""
    scans = tuple(
        (*each.mount.tolist(), each.angle_min, each.angle_increment, each.range_max)
        for each in observation.scans
    )
    clouds = tuple(tuple(map(str, each.mount.tolist())) for each in observation.clouds)
    return scans, clouds
