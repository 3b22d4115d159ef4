"""Scores of group detection by pairs, against annotated groups."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np
from scipy.stats import beta

from cohelm.arrays import Floats, Integers, value
from cohelm.messages import People
from cohelm.perception import GroupDetector
from cohelm.perception.tracking.kalman import predict, update
from cohelm.recordings import Trajectories

AGILITY = 0.5
"""Intensity of the white acceleration noise of the filter, m²/s³."""
ANNOTATION_NOISE = 0.05
"""Standard deviation of annotated positions along each axis, m."""
UNKNOWN_SPEED = 1.0
"""Initial standard deviation of a velocity along each axis, m/s."""
COURSE = 0.3
"""Speed above which the heading follows the motion, m/s."""
FORGOTTEN = 2.0
"""Time out of sight after which the filter restarts, s."""
BODY = 0.25
"""Radius of each body, m."""


@value
class GroupScores:
    """Detected and annotated pairs; a pair is detected in more than half of its common frames.

    Every pair of members of one list is annotated, once for all lists.
    """

    annotated: int
    """Annotated pairs, also those without a common frame."""
    apart: int
    """Annotated pairs without a common frame; they count as missed."""
    found: int
    """Detected pairs."""
    right: int
    """Pairs that are detected and annotated."""

    @property
    def precision(self) -> float:
        """Share of the detected pairs that are annotated; NaN without any."""
        return self.right / self.found if self.found else float("nan")

    @property
    def recall(self) -> float:
        """Share of the annotated pairs that are detected; NaN without any."""
        return self.right / self.annotated if self.annotated else float("nan")

    @property
    def f1(self) -> float:
        """2 · right / (found + annotated); NaN without either."""
        both = self.found + self.annotated
        return 2.0 * self.right / both if both else float("nan")

    def interval(self) -> tuple[float, float]:
        """95 % interval of F1 for independent pairs: that of Jeffreys for F1/(2 − F1).

        F1/(2 − F1) is the share of the right pairs among all detected or annotated ones. Pairs of
        one group are not independent, so the true interval is wider.
        """
        wrong = self.found + self.annotated - 2 * self.right
        low, high = beta.ppf([0.025, 0.975], self.right + 0.5, wrong + 0.5)
        return float(2.0 * low / (1.0 + low)), float(2.0 * high / (1.0 + high))


def group_scores(
    trajectories: Trajectories,
    groups: Sequence[Sequence[int]],
    detector: GroupDetector,
    *,
    noise: float = 0.0,
    seed: int = 0,
) -> GroupScores:
    """Score a detector on trajectories, frame by frame, against annotated groups.

    The true positions pass a Kalman filter, so that velocities do not depend on the future; ids are
    true. The filter restarts for a person who was out of sight for ``FORGOTTEN``.

    Args:
        trajectories: trajectories of all people.
        groups: lists of ids of members; a pair may be in several.
        detector: group detector.
        noise: standard deviation added to the positions along each axis, m.
        seed: seed of that noise.
    """
    ids = trajectories.id
    shared = np.zeros((len(ids), len(ids)), dtype=np.int64)
    together = np.zeros_like(shared)
    memory: Any = None
    for people in followed(trajectories, noise=noise, seed=seed):
        found, memory = detector.group(people, memory)
        block = np.ix_(*[np.searchsorted(ids, people.id)] * 2)
        shared[block] += 1
        same = (found.member[:, None] == found.member) & (found.member[:, None] >= 0)
        together[block] += same
    return _scores(ids, shared, together, groups)


def followed(trajectories: Trajectories, *, noise: float = 0.0, seed: int = 0) -> Iterator[People]:
    """People as a tracker without identity errors would report them, frame by frame."""
    rng = np.random.default_rng(seed)
    position = trajectories.position
    position = position + noise * rng.standard_normal(position.shape)
    who = np.repeat(np.arange(len(trajectories.id)), np.diff(trajectories.first))
    frames = np.argsort(trajectories.time, kind="stable")
    cuts = np.flatnonzero(np.diff(trajectories.time[frames])) + 1
    tracks = _Tracks(len(trajectories.id), float(np.hypot(noise, ANNOTATION_NOISE)))
    for frame in np.split(frames, cuts):
        if len(frame):
            rows = frame[np.argsort(who[frame])]
            time = float(trajectories.time[rows[0]])
            yield tracks.seen(trajectories.id, who[rows], position[rows], time)


class _Tracks:
    """State of the filter for all people during one iteration."""

    def __init__(self, n: int, deviation: float) -> None:
        self._last = np.full(n, -np.inf)
        self._mean = np.zeros((n, 4))
        self._covariance = np.zeros((n, 4, 4))
        self._heading = np.full(n, np.nan)
        self._deviation = deviation

    def seen(self, ids: Integers, who: Integers, position: Floats, time: float) -> People:
        n, r = len(who), self._deviation
        since = time - self._last[who]
        new = since > FORGOTTEN
        mean, covariance = predict(
            self._mean[who],
            self._covariance[who],
            np.where(new, 0.0, since),
            np.full(n, AGILITY),
        )
        mean, covariance = update(mean, covariance + 1e-12 * np.eye(4), position, np.full(n, r))
        mean[new] = np.concatenate([position, np.zeros((n, 2))], axis=1)[new]
        covariance[new] = np.diag([r**2, r**2, UNKNOWN_SPEED**2, UNKNOWN_SPEED**2])
        walks = np.hypot(mean[:, 2], mean[:, 3]) > COURSE
        kept = np.where(new, np.nan, self._heading[who])
        heading = np.where(walks, np.arctan2(mean[:, 3], mean[:, 2]), kept)
        self._last[who], self._heading[who] = time, heading
        self._mean[who], self._covariance[who] = mean, covariance
        return People(
            time=time,
            id=ids[who],
            mean=mean,
            covariance=covariance,
            heading=heading,
            radius=np.full(n, BODY),
            confidence=np.ones(n),
            source="annotated",
        )


def _scores(
    ids: Integers, shared: Integers, together: Integers, groups: Sequence[Sequence[int]]
) -> GroupScores:
    annotated = {pair for members in groups for pair in combinations(sorted(set(members)), 2)}
    first, second = np.nonzero(np.triu(2 * together > shared, 1))
    found = set(zip(ids[first].tolist(), ids[second].tolist(), strict=True))
    at = {each: k for k, each in enumerate(ids.tolist())}
    apart = [pair for pair in annotated if not all(each in at for each in pair)]
    present = annotated.difference(apart)
    apart += [(a, b) for a, b in present if shared[at[a], at[b]] == 0]
    return GroupScores(
        annotated=len(annotated),
        apart=len(apart),
        found=len(found),
        right=len(found & annotated),
    )
