"""Contracts of ``perception.Detector``, ``CloudDetector`` and ``Tracker``."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

import numpy as np

from cohelm.arrays import Floats, identical
from cohelm.geometry import compose, transform
from cohelm.maps import DistanceField
from cohelm.messages import Observation, People, PointCloud, Scan
from cohelm.perception.api import (
    CloudDetector,
    Detections,
    Detector,
    Tracker,
)
from cohelm.robots import LidarMount
from cohelm.simulation.sensors import HumanBodies, StaticScene, scan_cloud
from cohelm.testing.conformance import TOLERANCE, require, require_finite, steady
from cohelm.testing.scenes import BODY, RESOLUTION, room, scan_of, walkers, walls_of

_ROBOT = np.array([3.0, 4.0, 0.4])
_MOUNT = np.array([0.2, 0.0, 0.1])
_BODIES = np.array([[6.0, 4.5, BODY], [5.0, 2.0, BODY]])
_TICK = 0.1
_LOW_BOX = ((6.0, 5.5, 6.5, 6.0),)
_ELSEWHERE = np.array([-7.0, 3.0, 2.0])


def check_detector(detector: Detector, *, within: float = 1.0) -> None:
    """Check a detector in an empty room without people and with two people in view.

    Every return must be kept, of any class, and a person-sized disc in the open must be
    detected to within 0.15 m.

    Raises:
        ConformanceError: naming the violated rule.
    """
    walls = walls_of(room())
    for bodies in (np.empty((0, 3)), _BODIES):
        scan = scan_of(pose=_ROBOT, mount=_MOUNT, discs=bodies, time=2.0)
        found = _check_detections(detector, scan, walls, within)
        for x, y, _ in bodies:
            off = np.hypot(*(found.position - (x, y)).T)
            require(len(off) > 0 and off.min() < 0.15, f"must find the person at ({x}, {y})")
    for blind in (np.inf, np.nan):
        scan = dataclasses.replace(scan, ranges=np.full(len(scan.ranges), blind))
        found = _check_detections(detector, scan, walls, within)
        require(len(found.position) == 0, f"must find no person in a scan of {blind} only")


def check_cloud_detector(detector: CloudDetector, *, within: float = 1.0) -> None:
    """Check a cloud detector in a room: empty, with two people in view, with invalid clouds.

    An upright body must be detected to within 0.15 m, and a low box must remain an obstacle without
    detection. Moving robot and map together must move the detections. One return, none, or NaN must
    give no person.

    Raises:
        ConformanceError: naming the violated rule.
    """
    grid = room(boxes=_LOW_BOX)
    heights = np.where(grid.occupied(), np.float32(np.nan), np.float32(0.0))
    x0, y0, x1, y1 = np.round(np.array(_LOW_BOX[0]) / RESOLUTION).astype(int)
    heights[y0:y1, x0:x1] = 0.25
    scenery = StaticScene(grid=grid, heights=heights)
    walls = walls_of(room())
    for places in (np.empty((0, 2)), _BODIES[:, :2]):
        rng = np.random.default_rng(0)
        bodies = HumanBodies.standing(places)
        cloud = scan_cloud(LidarMount(), scenery, bodies, _ROBOT, time=2.0, rng=rng)
        found = _check_cloud(detector, cloud, walls, within)
        for x, y in places:
            off = np.hypot(*(found.position - (x, y)).T)
            require(len(off) > 0 and off.min() < 0.15, f"must find the person at ({x}, {y})")
        low, high = np.array([_LOW_BOX[0][:2], _LOW_BOX[0][2:]])
        beyond = np.maximum(low - found.points, found.points - high)
        box = (beyond < 0.1).all(axis=1) & ~found.mapped
        require(box.any(), "must keep low obstacles: a box of 0.25 m")
        require(found.detection_of_return[box] == -1, "a low box must belong to no detection")
        _check_moved(detector, cloud, walls, found)
    for points in (
        np.empty((0, 3)),
        np.full((50, 3), np.nan),
        np.full((50, 3), np.inf),
        np.array([[2.0, 0.0, 0.5]]),
        np.zeros((1000, 3)),
    ):
        empty = dataclasses.replace(cloud, points=points.astype(np.float32))
        found = _check_cloud(detector, empty, walls, within)
        require(len(found.position) == 0, f"must find no person in {len(points)} such points")


def _check_cloud(
    detector: CloudDetector, cloud: PointCloud, walls: DistanceField, within: float
) -> Detections:
    found = steady(
        partial(detector.detect, (cloud,), _ROBOT[None], walls),
        inputs=(cloud, walls),
        what="detect",
        within=within,
    )
    require(found.time == cloud.time, "detections must have the first cloud's time")
    require_finite(
        {"points": found.points, "free_ends": found.free_ends, "position": found.position}
    )
    d = len(found.position)
    require(
        (found.detection_of_return >= -1) & (found.detection_of_return < d),
        "detection_of_return must name a detection",
    )
    require(
        found.detection_of_return[found.mapped] == -1,
        "returns of the map must belong to no detection",
    )
    require(
        (found.cluster_of_return >= -1) & (found.cluster_of_return < len(found.ellipse)),
        "every cluster must have an ellipse",
    )
    require(found.radius > 0.0, "radius must be positive")
    require((found.confidence >= 0.0) & (found.confidence <= 1.0), "confidence must be in 0…1")
    return found


def _check_moved(
    detector: CloudDetector, cloud: PointCloud, walls: DistanceField, found: Detections
) -> None:
    """Check that moving robot and map moves the detections."""
    moved = dataclasses.replace(walls, X_MG=compose(_ELSEWHERE, walls.X_MG))
    there = detector.detect((cloud,), compose(_ELSEWHERE, _ROBOT)[None], moved)
    require(
        len(there.position) == len(found.position),
        "moving the world must not add or remove detections",
    )
    off = there.position - transform(_ELSEWHERE, found.position)
    require(np.abs(off) < 0.02, "moving robot and map must move the detections")


def _check_detections(
    detector: Detector, scan: Scan, walls: DistanceField, within: float
) -> Detections:
    found = steady(
        lambda: detector.detect(scan, _ROBOT, walls),
        inputs=(scan, _ROBOT, walls),
        what="detect",
        within=within,
    )
    require(found.time == scan.time, "detections must have the scan's time")
    require_finite({"points": found.points, "position": found.position, "radius": found.radius})
    seen = np.flatnonzero(scan.ranges <= scan.range_max)
    require(
        len(found.points) == len(seen),
        f"must keep all {len(seen)} returns of the scan, keeps {len(found.points)}",
    )
    angle = scan.angle_min + scan.angle_increment * seen
    ends = scan.ranges[seen, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    X_ML = compose(_ROBOT, scan.mount)
    turn = np.array([[np.cos(X_ML[2]), np.sin(X_ML[2])], [-np.sin(X_ML[2]), np.cos(X_ML[2])]])
    require(
        np.abs(found.points - (ends @ turn + X_ML[:2])) < TOLERANCE,
        "points must be the returns in the map frame, in the order of the beams",
    )
    require(
        (found.detection_of_return >= -1) & (found.detection_of_return < len(found.position)),
        "detection_of_return must name a detection",
    )
    require(found.radius > 0.0, "radius must be positive")
    require((found.confidence >= 0.0) & (found.confidence <= 1.0), "confidence must be in 0…1")
    return found


def check_tracker(tracker: Tracker, *, within: float = 1.0) -> None:
    """Check a tracker without people, and with two people, one walking, for three seconds.

    The people are present as detections and as given people, for either kind of tracker. Memory
    must be a value: equal calls give equal results, and no call changes an earlier result.

    Raises:
        ConformanceError: naming the violated rule.
    """
    require(isinstance(tracker.uses_change_detection, bool), "must say if it uses change detection")
    memory: Any = None
    for k in range(5):
        people, memory = _track(tracker, k * _TICK, np.empty((0, 4)), memory, within)
        require(len(people) == 0, "must not track a person on an empty floor")
    memory, ids = None, []
    for k in range(31):
        time = k * _TICK
        states = np.array([[3.0 + 1.0 * time, 0.5, 1.0, 0.0], [4.0, -2.0, 0.0, 0.0]])
        people, memory = _track(tracker, time, states, memory, within)
        ids.append(people.id)
    require(len(people) == 2, f"must track two people after three seconds, tracks {len(people)}")
    require(
        identical(np.sort(ids[-1]), np.sort(ids[-10])), "must keep a person's id from call to call"
    )
    for truth in states:
        off = np.hypot(*(people.mean[:, :2] - truth[:2]).T)
        require(off.min() < 0.2, f"must be within 0.2 m of the person at {truth[:2]}")
        slip = np.abs(people.mean[off.argmin(), 2:] - truth[2:]).max()
        require(slip < 0.25, f"must know the velocity {truth[2:]} to within 0.25 m/s")


def _track(
    tracker: Tracker, time: float, states: Floats, memory: Any, within: float
) -> tuple[People, Any]:
    observation = Observation(
        time=time,
        pose=np.zeros(3),
        pose_time=time,
        twist=np.zeros(3),
        twist_time=time,
        people=walkers(states, time=time, source="given"),
    )
    detections = (_detections(time, states[:, :2]),)
    people, after = steady(
        lambda: tracker.track(observation, detections, memory),
        inputs=(observation, detections, memory),
        what="track",
        within=within,
    )
    require(people.time == time, "people must have the observation's time")
    require(len(np.unique(people.id)) == len(people), "two people must not share an id")
    require_finite({"mean": people.mean, "covariance": people.covariance, "radius": people.radius})
    require(
        np.abs(people.covariance - people.covariance.swapaxes(1, 2)) < TOLERANCE,
        "covariances must be symmetric",
    )
    if len(people):
        require(
            np.linalg.eigvalsh(people.covariance) > -TOLERANCE, "covariances must not be negative"
        )
    require(people.radius > 0.0, "radius must be positive")
    require((people.confidence >= 0.0) & (people.confidence <= 1.0), "confidence must be in 0…1")
    return people, after


def _detections(time: float, centres: Floats) -> Detections:
    """Complete outlines of people, as scanned from all sides."""
    d = len(centres)
    angle = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    ring = BODY * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return Detections(
        time=time,
        origin=np.zeros(2),
        points=(centres[:, None] + ring).reshape(-1, 2),
        detection_of_return=np.repeat(np.arange(d), len(ring)),
        mapped=np.zeros(d * len(ring), dtype=np.bool_),
        free_ends=np.empty((0, 2)),
        position=centres,
        radius=np.full(d, BODY),
        deviation=np.full(d, 0.05),
        confidence=np.ones(d),
        cluster_of_return=np.repeat(np.arange(d), len(ring)),
        ellipse=np.column_stack([centres, np.full((d, 2), BODY), np.zeros(d)]),
    )
