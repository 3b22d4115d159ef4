"""Pipeline of perception: scans and clouds → detections → people → groups."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.geometry import compose
from cohelm.maps import DistanceField
from cohelm.messages import Groups, Observation, People, Scan, Sensing
from cohelm.perception.api import (
    CloudDetector,
    Detections,
    Detector,
    GroupDetector,
    Tracker,
)
from cohelm.perception.change_detection.cloud_changes import (
    detect_cloud_changes,
    remember_cloud,
)
from cohelm.perception.change_detection.past_scans import (
    ChangeDetectionParameters,
    PastScans,
    remember_scan,
)
from cohelm.perception.change_detection.scan_changes import (
    detect_changes,
)
from cohelm.perception.preprocessing.own_returns import (
    SteadyReturns,
    learn_own_returns,
    without_own_returns,
)
from cohelm.perception.sensor_clocks import CLOCK_RESET, Clocks, check_clocks
from cohelm.robots import move

MAX_DELAY = 0.5
"""Largest difference between the time of a reading and that of the pose over which the robot's own
motion is extrapolated, s."""
_RESET_STEP = 10.0 * CLOCK_RESET
"""Step back in time that trackers and group detectors take for a clock reset, s. It suffices if
their last reading is at most 9 s older than the observation."""


@value
class PerceptionParts:
    """Replaceable parts, in the order of processing."""

    detector: Detector
    cloud_detector: CloudDetector
    tracker: Tracker
    group_detector: GroupDetector
    change_detection: ChangeDetectionParameters = ChangeDetectionParameters()
    """Parameters of the comparison with earlier scans."""
    outline: Annotated[Floats, Shape("k 2")] | None = None
    """Footprint of the robot in its own frame, m: returns of scans within it are its own. None:
    unknown."""


@value
class PerceptionMemory:
    """State of the pipeline between two calls."""

    clocks: Clocks = Clocks()
    tracker: Any | None = None
    groups: Any | None = None
    past_scans: PastScans = ()
    """Earlier scans, for change detection."""
    past_clouds: PastScans = ()
    """Earlier clouds as planar scans of their upright columns."""
    steady_returns: tuple[SteadyReturns, ...] = ()
    """Of each scanner, for a robot of unknown outline."""
    mapped: bool = False
    """True if the map has ever explained a return: there is one."""


@value
class PerceptionResult:
    """People, groups, and the detections they are based on."""

    sensing: Sensing
    detections: tuple[Detections, ...]
    """One per usable scan, and one for all usable clouds together."""
    people: People
    groups: Groups


def perceive(
    parts: PerceptionParts,
    observation: Observation,
    walls: DistanceField,
    memory: PerceptionMemory | None,
) -> tuple[PerceptionResult, PerceptionMemory]:
    """Detect and track people up to ``observation.time``; also return the new memory.

    Readings with an invalid clock are removed. After a clock reset everything restarts, and only
    the ids continue.

    Args:
        parts: detectors and trackers.
        observation: readings of the sensors.
        walls: distance to the nearest wall of the static map at points of the map frame, m.
        memory: the one of the last call, None at first.
    """
    memory = memory or PerceptionMemory()
    check = check_clocks(observation, memory.clocks)
    observation = check.observation
    if check.reset:
        memory = _reset(parts, observation, memory)
    poses = tuple(pose_at(observation, scan.time) for scan in observation.scans)
    scans, steady = _others_returns(parts, observation.scans, poses, memory.steady_returns)
    observation = replace(observation, scans=scans)
    memory = replace(memory, clocks=check.clocks, steady_returns=steady)
    detections, memory = _detect_in_scans(parts, scans, poses, walls, memory)
    found, memory = _detect_in_clouds(parts, observation, walls, memory)
    detections += found
    people, tracker = parts.tracker.track(observation, detections, memory.tracker)
    groups, group_memory = parts.group_detector.group(people, memory.groups)
    returned = any(len(each.points) or len(each.free_ends) for each in detections)
    sensing = check.sensing
    if sensing is Sensing.OK and not returned:
        sensing = Sensing.NO_RETURNS
    return (
        PerceptionResult(sensing=sensing, detections=detections, people=people, groups=groups),
        replace(memory, tracker=tracker, groups=group_memory),
    )


def _detect_in_scans(
    parts: PerceptionParts,
    scans: tuple[Scan, ...],
    poses: tuple[Floats, ...],
    walls: DistanceField,
    memory: PerceptionMemory,
) -> tuple[tuple[Detections, ...], PerceptionMemory]:
    """Detections of each scan, compared with earlier scans if the tracker uses that."""
    detections = tuple(
        parts.detector.detect(scan, X_MR, walls) for scan, X_MR in zip(scans, poses, strict=True)
    )
    mapped = memory.mapped or any(found.mapped.any() for found in detections)
    past_scans = memory.past_scans
    if parts.tracker.uses_change_detection:
        # A map explains what comes into view.
        views = [
            None if mapped else compose(X_MR, scan.mount)
            for scan, X_MR in zip(scans, poses, strict=True)
        ]
        detections = tuple(
            detect_changes(found, past_scans, parts.change_detection, X_MS)
            for found, X_MS in zip(detections, views, strict=True)
        )
        for scan, X_MR in zip(scans, poses, strict=True):
            past_scans = remember_scan(past_scans, scan, X_MR, parts.change_detection)
    return detections, replace(memory, past_scans=past_scans, mapped=mapped)


def _detect_in_clouds(
    parts: PerceptionParts,
    observation: Observation,
    walls: DistanceField,
    memory: PerceptionMemory,
) -> tuple[tuple[Detections, ...], PerceptionMemory]:
    """Detections of all clouds together, at most one, compared with earlier clouds."""
    if not observation.clouds:
        return (), memory
    poses = np.array([pose_at(observation, cloud.time) for cloud in observation.clouds])
    found = parts.cloud_detector.detect(observation.clouds, poses, walls)
    past_clouds = remember_cloud(memory.past_clouds, found)
    compared = detect_cloud_changes(found, memory.past_clouds)
    return (compared,), replace(memory, past_clouds=past_clouds)


def _others_returns(
    parts: PerceptionParts,
    scans: tuple[Scan, ...],
    poses: tuple[Floats, ...],
    steady: tuple[SteadyReturns, ...],
) -> tuple[tuple[Scan, ...], tuple[SteadyReturns, ...]]:
    """Scans without the returns of the robot itself; also return the steady ones."""
    out = []
    for scan, X_MR in zip(scans, poses, strict=True):
        seen = without_own_returns(scan, parts.outline)
        if parts.outline is None:
            seen, steady = learn_own_returns(seen, X_MR, steady)
        out.append(seen)
    return tuple(out), steady


def _reset(
    parts: PerceptionParts, observation: Observation, memory: PerceptionMemory
) -> PerceptionMemory:
    """Clear ``memory`` except for the counters of ids.

    Trackers and group detectors are called with an early time and without readings, see
    :meth:`Tracker.track`.
    """
    time = observation.time - _RESET_STEP
    tracker, groups = memory.tracker, memory.groups
    if tracker is not None:
        before = replace(observation, time=time, scans=(), clouds=(), people=None)
        _, tracker = parts.tracker.track(before, (), tracker)
    if groups is not None:
        _, groups = parts.group_detector.group(People.empty(time), groups)
    return PerceptionMemory(tracker=tracker, groups=groups)


def pose_at(observation: Observation, time: float) -> Floats:
    """Robot pose (3,) at ``time``, extrapolated from the observation's pose and twist."""
    since = time - observation.pose_time
    if not math.isfinite(since) or not np.isfinite(observation.twist).all():
        return observation.pose
    return move(observation.pose, observation.twist, min(max(since, -MAX_DELAY), MAX_DELAY))
