"""A film seen by a detector that is only imagined: its errors are drawn, not found."""

from __future__ import annotations

import numpy as np

from cohelm.evaluation.perception.filmed_crowd import crowd_instants
from cohelm.evaluation.perception.tracking_scores import tracking_scores
from cohelm.geometry import compose, inverse, transform
from cohelm.perception import Detections

from .rays import cast

R = 0.25
BEAMS = np.linspace(-np.pi, np.pi, 720, endpoint=False)
REACH = 10.0


def shares(origin, position, ranges):
    """How much of each disc (n,) the beams that meet it alone also meet among the others."""
    out = np.zeros(len(position))
    for i, place in enumerate(position):
        alone = cast(origin, BEAMS, np.empty((0, 4)), np.array([[*place, R]]))
        meets = np.isfinite(alone) & (alone <= REACH)
        out[i] = np.mean(alone[meets] <= ranges[meets] + 1e-9) if meets.any() else 0.0
    return out


def imagine(instant, rng, *, missed=0.05, clutter=0.2, merging=0.5):
    """(detections, visible shares) of an instant.

    Half-hidden people are placed worse: 3 cm of noise, 8 cm where a third is to be seen. Of two
    bodies less than 0.1 m apart every other look makes one wide one. The pose is the told one.
    """
    origin = instant.pose[:2]
    people = instant.position
    discs = np.column_stack([people, np.full(len(people), R)])
    ranges = cast(origin, BEAMS, np.empty((0, 4)), discs)
    visible = shares(origin, people, ranges)
    away = np.hypot(*(people - origin).T)
    found = (visible > 0.15) & (away < REACH) & (away > 0.3) & (rng.random(len(people)) >= missed)
    spread = 0.03 + 0.07 * (1.0 - np.minimum(visible, 1.0))
    places = people + spread[:, None] * rng.standard_normal(people.shape)
    radius, confidence = np.full(len(people), R), np.full(len(people), 0.95)
    confidence[visible < 0.5] = 0.75
    for i in range(len(people)):
        for j in range(i):
            near = np.hypot(*(people[i] - people[j])) < 2 * R + 0.1
            if found[i] and found[j] and near and rng.random() < merging:
                places[j], radius[j], confidence[j] = 0.5 * (places[i] + places[j]), 0.4, 0.6
                found[i] = False
    ghosts = origin + rng.uniform(-REACH, REACH, (rng.poisson(clutter), 2))
    places = np.concatenate([places[found], ghosts])
    told = compose(instant.observation.pose, inverse(instant.pose))
    hit = ranges <= REACH
    beams = np.stack([np.cos(BEAMS), np.sin(BEAMS)], axis=-1)
    points = origin + ranges[hit, None] * beams[hit]
    nothing = Detections.empty(instant.observation.time, instant.observation.pose[:2])
    fields = {name: getattr(nothing, name) for name in ("time", "origin", "ellipse")}
    count = int(hit.sum())
    return Detections(
        **fields,
        points=_moved(told, points),
        detection_of_return=np.full(count, -1),
        mapped=np.zeros(count, dtype=bool),
        cluster_of_return=np.full(count, -1),
        free_ends=_moved(told, origin + REACH * beams[~hit]),
        position=_moved(told, places),
        radius=np.concatenate([radius[found], np.full(len(ghosts), 0.3)]),
        deviation=np.concatenate([spread[found], np.full(len(ghosts), 0.05)]),
        confidence=np.concatenate([confidence[found], rng.uniform(0.1, 0.8, len(ghosts))]),
    ), visible


def _moved(X, points):
    return np.asarray(transform(X, points)).reshape(-1, 2)


def scores(tracker, film, *, seed, drive, start=0.0, seconds=np.inf, **errors):
    """``tracking_scores`` of a tracker on a film so seen."""
    rng = np.random.default_rng(seed)
    memory, truth, told = None, [], []
    for instant in crowd_instants(film, seed=seed, drive=drive, start=start, seconds=seconds):
        seen, visible = imagine(instant, rng, **errors)
        people, memory = tracker.track(instant.observation, (seen,), memory)
        truth.append(instant.truth(visible))
        told.append(people)
    return tracking_scores(truth, told)
