"""The pipeline of perception: scans and clouds → detections → people → groups."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.maps import DistanceField
from cohelm.messages import Groups, Observation, People, Sensing
from cohelm.perception.api import (
    CloudDetector,
    Detections,
    Detector,
    GroupDetector,
    Tracker,
)
from cohelm.perception.clock import RAN_BACK, Clocks, timely
from cohelm.perception.cloud_past import remember_place, with_place
from cohelm.perception.novelty import NoveltyParameters, Past, remember, with_motion
from cohelm.robots import move

OLDEST = 0.5
"""The chair's own motion since a scan is made good for at most so long, s."""
_LONG_AGO = 10.0 * RAN_BACK
"""So far before now is before all that is remembered, where time ran back, s."""


@value
class PerceptionParts:
    """The replaceable parts, in the order in which they work."""

    detector: Detector
    cloud_detector: CloudDetector
    tracker: Tracker
    group_detector: GroupDetector
    novelty: NoveltyParameters = NoveltyParameters()
    """How scans are compared with earlier ones."""


@value
class PerceptionMemory:
    """What the parts need of the past."""

    clocks: Clocks = Clocks()
    tracker: Any | None = None
    groups: Any | None = None
    past: Past = ()
    """Scans to compare the next ones with."""
    stood: Past = ()
    """The same of what stood in clouds."""


@value
class Perceived:
    """Who is there, and what else was seen."""

    sensing: Sensing
    detections: tuple[Detections, ...]
    """One for each scan that can be used, and one for all such clouds together."""
    people: People
    groups: Groups


def perceive(
    parts: PerceptionParts,
    observation: Observation,
    walls: DistanceField,
    memory: PerceptionMemory | None,
) -> tuple[Perceived, PerceptionMemory]:
    """Who is there at ``observation.time``, and the memory for the next call.

    What a clock out of step makes useless is left out; where time ran back all begins anew, and
    only ids go on.

    Args:
        parts: that do the work.
        observation: what the sensors say.
        walls: the static map's distances.
        memory: what the last call returned, None at first.
    """
    memory = memory or PerceptionMemory()
    use = timely(observation, memory.clocks)
    observation = use.observation
    if use.anew:
        memory = _forgotten(parts, observation, memory)
    poses = tuple(pose_at(observation, scan.time) for scan in observation.scans)
    detections = tuple(
        parts.detector.detect(scan, X_MR, walls)
        for scan, X_MR in zip(observation.scans, poses, strict=True)
    )
    past, stood = memory.past, memory.stood
    if getattr(parts.tracker, "asks_for_motion", True):
        detections = tuple(with_motion(seen, past, parts.novelty) for seen in detections)
        for scan, X_MR in zip(observation.scans, poses, strict=True):
            past = remember(past, scan, X_MR, parts.novelty)
    if observation.clouds:
        taken_at = np.array([pose_at(observation, cloud.time) for cloud in observation.clouds])
        seen = parts.cloud_detector.detect(observation.clouds, taken_at, walls)
        detections += (with_place(seen, memory.stood),)
        stood = remember_place(stood, seen)
    people, tracker = parts.tracker.track(observation, detections, memory.tracker)
    groups, grouping = parts.group_detector.group(people, memory.groups)
    returned = any(len(each.points) or len(each.through) for each in detections)
    sensing = Sensing.NO_RETURNS if use.sensing is Sensing.OK and not returned else use.sensing
    perceived = Perceived(sensing=sensing, detections=detections, people=people, groups=groups)
    return perceived, PerceptionMemory(
        clocks=use.clocks, tracker=tracker, groups=grouping, past=past, stood=stood
    )


def _forgotten(
    parts: PerceptionParts, observation: Observation, memory: PerceptionMemory
) -> PerceptionMemory:
    """``memory`` without anything but the ids that were given.

    Trackers and group detectors end all at a time long before what they remember.
    """
    time = observation.time - _LONG_AGO
    tracker, groups = memory.tracker, memory.groups
    if tracker is not None:
        before = replace(observation, time=time, scans=(), clouds=(), people=None)
        _, tracker = parts.tracker.track(before, (), tracker)
    if groups is not None:
        _, groups = parts.group_detector.group(People.nobody(time), groups)
    return PerceptionMemory(tracker=tracker, groups=groups)


def pose_at(observation: Observation, time: float) -> Floats:
    """Where the robot was (3,) at ``time``, from the pose and the twist that are known now."""
    since = time - observation.pose_time
    if not math.isfinite(since) or not np.isfinite(observation.twist).all():
        return observation.pose
    return move(observation.pose, observation.twist, min(max(since, -OLDEST), OLDEST))
