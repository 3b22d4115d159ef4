"""The pipeline of perception: scans and clouds → detections → people → groups."""

from __future__ import annotations

import math
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
from cohelm.perception.clock import Clocks, read_clocks
from cohelm.perception.novelty import Past, remember, with_motion
from cohelm.robots import move

OLDEST = 0.5
"""The chair's own motion since a scan is made good for at most so long, s."""


@value
class PerceptionParts:
    """The replaceable parts, in the order in which they work."""

    detector: Detector
    cloud_detector: CloudDetector
    tracker: Tracker
    group_detector: GroupDetector


@value
class PerceptionMemory:
    """What the parts need of the past."""

    clocks: Clocks = Clocks()
    tracker: Any | None = None
    groups: Any | None = None
    past: Past = ()
    """Scans to compare the next ones with."""


@value
class Perceived:
    """Who is there, and what else was seen."""

    sensing: Sensing
    detections: tuple[Detections, ...]
    """One for each scan, and one for all clouds together."""
    people: People
    groups: Groups


def perceive(
    parts: PerceptionParts,
    observation: Observation,
    walls: DistanceField,
    memory: PerceptionMemory | None,
) -> tuple[Perceived, PerceptionMemory]:
    """Who is there at ``observation.time``, and the memory for the next call.

    Args:
        parts: that do the work.
        observation: what the sensors say.
        walls: the static map's distances.
        memory: what the last call returned, None at first.
    """
    memory = memory or PerceptionMemory()
    poses = tuple(pose_at(observation, scan.time) for scan in observation.scans)
    detections = tuple(
        with_motion(parts.detector.detect(scan, X_MR, walls), memory.past)
        for scan, X_MR in zip(observation.scans, poses, strict=True)
    )
    past = memory.past
    for scan, X_MR in zip(observation.scans, poses, strict=True):
        past = remember(past, scan, X_MR)
    if observation.clouds:
        taken_at = np.array([pose_at(observation, cloud.time) for cloud in observation.clouds])
        detections += (parts.cloud_detector.detect(observation.clouds, taken_at, walls),)
    people, tracker = parts.tracker.track(observation, detections, memory.tracker)
    groups, grouping = parts.group_detector.group(people, memory.groups)
    sensing, clocks = read_clocks(observation, memory.clocks)
    if sensing is Sensing.OK and not any(len(d.points) or len(d.through) for d in detections):
        sensing = Sensing.NO_RETURNS
    perceived = Perceived(sensing=sensing, detections=detections, people=people, groups=groups)
    return perceived, PerceptionMemory(clocks=clocks, tracker=tracker, groups=grouping, past=past)


def pose_at(observation: Observation, time: float) -> Floats:
    """Where the robot was (3,) at ``time``, from the pose and the twist that are known now."""
    since = time - observation.pose_time
    if not math.isfinite(since) or not np.isfinite(observation.twist).all():
        return observation.pose
    return move(observation.pose, observation.twist, min(max(since, -OLDEST), OLDEST))
