"""Scores of perception on a filmed crowd, from the cloud to the people told."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from time import thread_time

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.evaluation.perceived import Instant, crowd_instants
from cohelm.evaluation.perceived_eyes import LidarEyes
from cohelm.evaluation.perceived_scores import (
    WITHIN,
    TrackingScores,
    TruePeople,
    tracking_scores,
)
from cohelm.evaluation.watching import NO_MAP, perception_of
from cohelm.messages import People, PointCloud
from cohelm.perception import Detections, PerceptionMemory, PerceptionParts, perceive
from cohelm.recordings import Trajectories

Eyes = Callable[[Instant], tuple[PointCloud, Floats]]
"""The cloud that the sensor gives of an instant, and the share of each person that it sees."""


@value
class CrowdScores:
    """What perception made of a filmed crowd; f frames, s sightings of people asked for."""

    name: str
    """Of the film."""
    drive: bool
    """Whether the chair drove."""
    seed: int
    tracking: TrackingScores
    detected: Annotated[Booleans, Shape("s")]
    """Whether a detection of the frame was within reach of the person of each sighting."""
    cost: Annotated[Floats, Shape("f")]
    """Of ``perceive`` in each frame, thread CPU time, s."""


def crowd_scores(
    trajectories: Trajectories,
    *,
    seed: int,
    drive: bool,
    start: float = 0.0,
    seconds: float = math.inf,
    parts: PerceptionParts | None = None,
    eyes: Eyes | None = None,
) -> CrowdScores:
    """Walk a film through the simulated LiDAR and say what perception made of it.

    Args:
        trajectories: who walked where.
        seed: of the sensors' and the localiser's errors and of the bodies.
        drive: whether the chair drives; else it stands.
        start: first moment, s since the film's first frame.
        seconds: how much of it.
        parts: that do the work; None: the default ones.
        eyes: the sensor; None: the default LiDAR.

    Raises:
        PluginError: where py-motmetrics is not installed.
    """
    eyes = eyes or LidarEyes(trajectories, seed)
    parts = parts or perception_of()
    memory: PerceptionMemory | None = None
    truth: list[TruePeople] = []
    told: list[People] = []
    found: list[tuple[Detections, ...]] = []
    cost: list[float] = []
    for instant in crowd_instants(
        trajectories, seed=seed, drive=drive, start=start, seconds=seconds
    ):
        cloud, visible = eyes(instant)
        observation = replace(instant.observation, clouds=(cloud,))
        before = thread_time()
        perceived, memory = perceive(parts, observation, NO_MAP, memory)
        cost.append(thread_time() - before)
        truth.append(instant.truth(visible))
        told.append(perceived.people)
        found.append(perceived.detections)
    return CrowdScores(
        name=trajectories.name,
        drive=drive,
        seed=seed,
        tracking=tracking_scores(truth, told),
        detected=np.concatenate(
            [_detected(true, seen) for true, seen in zip(truth, found, strict=True)]
            or [np.empty(0, dtype=np.bool_)]
        ),
        cost=np.array(cost),
    )


def _detected(true: TruePeople, seen: tuple[Detections, ...]) -> Booleans:
    """Of those asked for, who has a detection near."""
    places = np.concatenate([np.empty((0, 2)), *(each.position for each in seen)])
    offset = true.position[true.asked, None] - places[None]
    near: Booleans = np.any(np.hypot(offset[..., 0], offset[..., 1]) <= WITHIN, axis=1)
    return near
