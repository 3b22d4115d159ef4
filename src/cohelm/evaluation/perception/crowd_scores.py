"""Scores of perception on a filmed crowd, from the point cloud to tracked people."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from time import thread_time

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.evaluation.perception.filmed_crowd import CrowdLidar, FilmInstant, crowd_instants
from cohelm.evaluation.perception.recording_view import NO_MAP, perception_of
from cohelm.evaluation.perception.tracking_scores import (
    WITHIN,
    TrackingScores,
    TruePeople,
    tracking_scores,
)
from cohelm.messages import People, PointCloud
from cohelm.perception import Detections, PerceptionMemory, PerceptionParts, perceive
from cohelm.recordings import Trajectories

CrowdSensor = Callable[[FilmInstant], tuple[PointCloud, Floats]]
"""Sensor: point cloud of an instant, and the visible share of each person."""


@value
class CrowdScores:
    """Scores of perception on a filmed crowd; f frames, s sightings of required people."""

    name: str
    """Name of the film."""
    drive: bool
    """True where the chair drove."""
    seed: int
    tracking: TrackingScores
    detected: Annotated[Booleans, Shape("s")]
    """True where a detection of the frame was near the person of the sighting."""
    cost: Annotated[Floats, Shape("f")]
    """Thread CPU time of ``perceive`` in each frame, s."""


def crowd_scores(
    trajectories: Trajectories,
    *,
    seed: int,
    drive: bool,
    start: float = 0.0,
    seconds: float = math.inf,
    parts: PerceptionParts | None = None,
    sensor: CrowdSensor | None = None,
) -> CrowdScores:
    """Run perception on a film in front of the simulated LiDAR.

    Args:
        trajectories: the film.
        seed: seed of sensor and localisation errors and of the bodies.
        drive: drive the chair.
        start: first instant, s since the first frame.
        seconds: duration, s.
        parts: parts of perception; None: the default ones.
        sensor: source of the clouds; None: the default LiDAR.

    Raises:
        PluginError: where py-motmetrics is not installed.
    """
    sensor = sensor or CrowdLidar(trajectories, seed)
    parts = parts or perception_of()
    memory: PerceptionMemory | None = None
    truth: list[TruePeople] = []
    tracked: list[People] = []
    found: list[tuple[Detections, ...]] = []
    cost: list[float] = []
    for instant in crowd_instants(
        trajectories, seed=seed, drive=drive, start=start, seconds=seconds
    ):
        cloud, visible = sensor(instant)
        observation = replace(instant.observation, clouds=(cloud,))
        before = thread_time()
        perceived, memory = perceive(parts, observation, NO_MAP, memory)
        cost.append(thread_time() - before)
        truth.append(instant.truth(visible))
        tracked.append(perceived.people)
        found.append(perceived.detections)
    return CrowdScores(
        name=trajectories.name,
        drive=drive,
        seed=seed,
        tracking=tracking_scores(truth, tracked),
        detected=np.concatenate(
            [_detected(true, seen) for true, seen in zip(truth, found, strict=True)]
            or [np.empty(0, dtype=np.bool_)]
        ),
        cost=np.array(cost),
    )


def _detected(true: TruePeople, seen: tuple[Detections, ...]) -> Booleans:
    """Required people with a detection nearby."""
    positions = np.concatenate([np.empty((0, 2)), *(each.position for each in seen)])
    offset = true.position[true.required, None] - positions[None]
    near: Booleans = np.any(np.hypot(offset[..., 0], offset[..., 1]) <= WITHIN, axis=1)
    return near
