"""Filmed pedestrians as the tracker reports them.

Between two sightings people walk on straight lines, and are detected there with noise at every
scan. At the instants of the film no detection depends on a future sighting: predictions that are
scored at these instants alone do not use the future.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.arrays import Floats, Integers, value
from cohelm.messages import Observation, People
from cohelm.perception import Detections, KalmanTracker, Tracker
from cohelm.recordings.pedestrians.trajectories import Trajectories

_NEAR = 0.6  # m, between a track and its pedestrian
_BODY = 0.25  # m
_SAME = 1e-3  # s


@value
class TrackedFilm:
    """Tracked crowd, scan by scan."""

    walks: Trajectories
    people: tuple[People, ...]
    walker: tuple[Integers, ...]
    """Index of the pedestrian of each of ``people``, −1: none."""


def track_film(
    walks: Trajectories,
    *,
    rate: float | None = 10.0,
    noise: float = 0.035,
    seed: int = 0,
    tracker: Tracker | None = None,
) -> TrackedFilm:
    """Track a filmed crowd.

    Args:
        walks: trajectories of the people.
        rate: rate of the scans, Hz; None: one at each instant of the film.
        noise: standard deviation of a detected position on each axis, m.
        seed: seed of the noise.
        tracker: tracker; None: the default one.
    """
    rng = np.random.default_rng(seed)
    tracker = tracker or KalmanTracker()
    instants = walks.instants
    times = instants
    if rate is not None and len(instants):
        times = np.arange(instants[0], instants[-1] + 1.0 / rate, 1.0 / rate)
    memory: Any = None
    tracked, walker = [], []
    for time in times:
        who, position = _there(walks, float(time))
        seen = detections(
            float(time), position + noise * rng.standard_normal(position.shape), noise
        )
        people, memory = tracker.track(Observation.at_rest(float(time)), (seen,), memory)
        tracked.append(people)
        walker.append(_nearest(people.mean[:, :2], who, position))
    return TrackedFilm(walks=walks, people=tuple(tracked), walker=tuple(walker))


def detections(time: float, position: Floats, deviation: float, *, returns: int = 0) -> Detections:
    """Detections at ``position`` (d, 2), with a number of returns around each of them."""
    d = len(position)
    person = np.repeat(np.arange(d), returns)
    angle = np.arange(returns) * 2.0 * np.pi / max(returns, 1)
    around = _BODY * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return replace(
        Detections.empty(time, np.zeros(2)),
        points=(position[:, None] + around).reshape(-1, 2),
        detection_of_return=person,
        mapped=np.zeros(len(person), dtype=np.bool_),
        cluster_of_return=person,
        ellipse=np.column_stack([position, np.full((d, 2), _BODY), np.zeros(d)]),
        position=position,
        radius=np.full(d, _BODY),
        deviation=np.full(d, deviation),
        confidence=np.full(d, 0.9),
    )


def _there(walks: Trajectories, time: float) -> tuple[Integers, Floats]:
    """Indices and positions of the people present, on straight lines between sightings."""
    seen = walks.last_before(time + _SAME)
    a = np.maximum(seen, walks.first[:-1])
    b = np.minimum(a + 1, walks.first[1:] - 1)
    length = np.maximum(walks.time[b] - walks.time[a], 1e-9)
    share = np.clip((time - walks.time[a]) / length, 0.0, 1.0)[:, None]
    who = np.flatnonzero((seen >= 0) & (time <= walks.end + _SAME))
    position = walks.position[a] + share * (walks.position[b] - walks.position[a])
    return who, position[who]


def _nearest(tracks: Floats, who: Integers, position: Floats) -> Integers:
    """Index of the pedestrian of each track (n, 2), (n,), −1: none."""
    if len(who) == 0 or len(tracks) == 0:
        return np.full(len(tracks), -1)
    apart = np.hypot(*(tracks[:, None] - position[None]).transpose(2, 0, 1))
    return np.where(apart.min(axis=1) < _NEAR, who[apart.argmin(axis=1)], -1)
