"""How well groups are found: by pairs, against those that somebody noted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np
from scipy.stats import beta

from cohelm.arrays import Floats, Integers, value
from cohelm.messages import People
from cohelm.perception import GroupDetector
from cohelm.perception.kalman import predict, update
from cohelm.recordings import Trajectories

AGILITY = 0.5
"""Intensity of the white acceleration with which the walks are followed, m²/s³."""
NOTED = 0.05
"""Deviation of the positions that people noted down, along each axis, m."""
UNKNOWN_SPEED = 1.0
"""Deviation of the velocity of who is seen for the first time, along each axis, m/s."""
COURSE = 0.3
"""Least speed at which the heading follows the motion, m/s."""
FORGOTTEN = 2.0
"""Who was out of sight for longer is followed anew, s."""
BODY = 0.25
"""Radius of everybody, m."""


@value
class GroupScores:
    """Pairs found, of those noted; found is who is together in more than half of what they share.

    Every pair of members of one list is noted, once, however many lists name it.
    """

    noted: int
    """Pairs, those included who never share a frame."""
    apart: int
    """Of them, pairs that never share a frame; they count as missed."""
    found: int
    """Pairs."""
    right: int
    """Pairs both found and noted."""

    @property
    def precision(self) -> float:
        """Share of the found that were noted; NaN where none was found."""
        return self.right / self.found if self.found else float("nan")

    @property
    def recall(self) -> float:
        """Share of the noted that were found; NaN where none was noted."""
        return self.right / self.noted if self.noted else float("nan")

    @property
    def f1(self) -> float:
        """2 · right / (found + noted); NaN where there is neither."""
        both = self.found + self.noted
        return 2.0 * self.right / both if both else float("nan")

    def interval(self) -> tuple[float, float]:
        """A 95 % interval of F1 with pairs as they come: that of Jeffreys for F1/(2 − F1).

        F1/(2 − F1) is the share of the right among all that were found or noted. Pairs of one
        group are not independent, so the true interval is wider.
        """
        wrong = self.found + self.noted - 2 * self.right
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
    """What ``detector`` makes of everybody's walks, frame by frame, against the lists.

    The true positions go through a Kalman filter, so that velocities know nothing of the future;
    ids are true. Who was out of sight for ``FORGOTTEN`` comes back as new to the filter.

    Args:
        trajectories: how everybody walked.
        groups: lists of ids of those who belong together; a pair may be in several.
        detector: of groups.
        noise: deviation added to the positions along each axis, m.
        seed: of that noise.
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
    """Everybody as a tracker that never errs about who is who would have them, frame by frame."""
    rng = np.random.default_rng(seed)
    position = trajectories.position
    position = position + noise * rng.standard_normal(position.shape)
    who = np.repeat(np.arange(len(trajectories.id)), np.diff(trajectories.first))
    frames = np.argsort(trajectories.time, kind="stable")
    cuts = np.flatnonzero(np.diff(trajectories.time[frames])) + 1
    tracks = _Tracks(len(trajectories.id), float(np.hypot(noise, NOTED)))
    for frame in np.split(frames, cuts):
        if len(frame):
            rows = frame[np.argsort(who[frame])]
            time = float(trajectories.time[rows[0]])
            yield tracks.seen(trajectories.id, who[rows], position[rows], time)


class _Tracks:
    """The filter's state of everybody; lives as long as the one iteration that it serves."""

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
            source="noted",
        )


def _scores(
    ids: Integers, shared: Integers, together: Integers, groups: Sequence[Sequence[int]]
) -> GroupScores:
    noted = {pair for members in groups for pair in combinations(sorted(set(members)), 2)}
    first, second = np.nonzero(np.triu(2 * together > shared, 1))
    found = set(zip(ids[first].tolist(), ids[second].tolist(), strict=True))
    at = {each: k for k, each in enumerate(ids.tolist())}
    apart = [pair for pair in noted if not all(each in at for each in pair)]
    present = noted.difference(apart)
    apart += [(a, b) for a, b in present if shared[at[a], at[b]] == 0]
    return GroupScores(
        noted=len(noted), apart=len(apart), found=len(found), right=len(found & noted)
    )
