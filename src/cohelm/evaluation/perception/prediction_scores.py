"""Scores of predictors on filmed crowds.

Predictions are scored at the instants of the film only, see ``tracked_film``. Frames of one person
are correlated, so intervals come from resampling people, not frames.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.evaluation.perception.tracked_film import TrackedFilm
from cohelm.evaluation.report.statistics import NO_ESTIMATE, Estimate, bootstrap
from cohelm.perception import Predictor
from cohelm.recordings.pedestrians.trajectories import Trajectories

AHEAD = 1.2
"""Prediction time, s."""
_SAMPLES = 200  # of a mixture, for its highest-density region
_SAME = 1e-3  # s


@value
class PredictionSamples:
    """k frames of tracked people whose position is known ``AHEAD`` later."""

    names: tuple[str, ...]
    """Names of the h hypotheses."""
    person: Annotated[Integers, Shape("k")]
    time: Annotated[Floats, Shape("k")]
    """s."""
    weight: Annotated[Floats, Shape("k h")]
    """Probabilities of the hypotheses."""
    density: Annotated[Floats, Shape("k h")]
    """Log density of each hypothesis at the true position, ln 1/m²."""
    offset: Annotated[Floats, Shape("k h 2")]
    """True position minus the mean of each hypothesis, m."""
    deviation: Annotated[Floats, Shape("k h")]
    """m."""

    @property
    def error(self) -> Floats:
        """Distance (k,) from the mean of the mixture to the true position, m."""
        out: Floats = np.hypot(*(self.weight[..., None] * self.offset).sum(axis=1).T)
        return out

    def log_likelihood(self) -> Floats:
        """Log density of the mixture at the true position, (k,)."""
        top = self.density.max(axis=1, keepdims=True)
        out: Floats = top[:, 0] + np.log((self.weight * np.exp(self.density - top)).sum(axis=1))
        return out

    def within(self, share: float = 0.9) -> float:
        """Share of the true positions in the highest-density regions with probability ``share``.

        The threshold of the density comes from 200 samples of each mixture.
        """
        rng = np.random.default_rng(0)
        k, rows = len(self.person), np.arange(len(self.person))
        u = rng.random((_SAMPLES, k, 1))
        picked = np.minimum((u > np.cumsum(self.weight, axis=1)).sum(axis=2), len(self.names) - 1)
        denser = np.zeros(k)
        here = self.log_likelihood()
        for pick in picked:
            noise = self.deviation[rows, pick][:, None] * rng.standard_normal((k, 2))
            # offset of a sample from the mean of each hypothesis
            off = noise[:, None] + self.offset - self.offset[rows, pick][:, None]
            there = replace(self, density=_density(off, self.deviation), offset=off)
            denser += there.log_likelihood() > here
        return float(np.mean(denser / _SAMPLES < share))


def predict_film(
    watched: TrackedFilm, predictor: Predictor, *, ahead: float = AHEAD, steps: int = 12
) -> PredictionSamples:
    """Predict the crowd at the instants of the film."""
    walks, instants = watched.walks, watched.walks.instants
    memory: Any = None
    names: tuple[str, ...] = ()
    found: list[tuple[Any, ...]] = []
    for people, walker in zip(watched.people, watched.walker, strict=True):
        predictions, memory = predictor.predict(people, steps, ahead / steps, memory)
        names = predictions.names
        if not len(instants) or np.abs(instants - people.time).min() > _SAME:
            continue
        future = _future(walks, walker, people.time, ahead)
        for i in np.flatnonzero(np.isfinite(future[:, 0])):
            offset = future[i] - predictions.mean[i, :, -1]
            found.append(
                (
                    walker[i],
                    people.time,
                    predictions.weight[i],
                    offset,
                    predictions.deviation[i, :, -1],
                )
            )
    h = len(names)
    person, time, weight, offset, deviation = zip(*found, strict=True) if found else ((),) * 5
    offsets = np.array(offset).reshape(-1, h, 2)
    deviations = np.array(deviation).reshape(-1, h)
    return PredictionSamples(
        names=names,
        person=np.array(person, dtype=np.int64),
        time=np.array(time, dtype=float),
        weight=np.array(weight).reshape(-1, h),
        density=_density(offsets, deviations),
        offset=offsets,
        deviation=deviations,
    )


def by_person(values: Floats, person: Integers) -> Estimate:
    """Mean over frames (k,), with an interval from resampling people."""
    people, index = np.unique(person, return_inverse=True)
    if len(people) == 0:
        return NO_ESTIMATE
    total = np.asarray(np.bincount(index, values), dtype=float)
    frames = np.asarray(np.bincount(index), dtype=float)
    low, high = float(values.mean()), float(values.mean())
    if len(people) > 1:
        low, high = bootstrap((total, frames), _ratio)
    return Estimate(mean=float(values.mean()), low=low, high=high, count=len(values))


def _ratio(total: Floats, frames: Floats, axis: int = -1) -> Floats:
    ratio: Floats = total.sum(axis=axis) / frames.sum(axis=axis)
    return ratio


def _future(walks: Trajectories, walker: Integers, time: float, ahead: float) -> Floats:
    """Future positions (n, 2), NaN where unknown, m."""
    future = np.full((len(walker), 2), np.nan)
    for i in np.flatnonzero(walker >= 0):
        own = slice(walks.first[walker[i]], walks.first[walker[i] + 1])
        times, positions = walks.time[own], walks.position[own]
        now, then = (int(np.abs(times - t).argmin()) for t in (time, time + ahead))
        if max(abs(times[now] - time), abs(times[then] - time - ahead)) <= _SAME:
            future[i] = positions[then]
    return future


def _density(offset: Floats, deviation: Floats) -> Floats:
    """Log of isotropic normal densities, offsets (…, 2)."""
    squared = np.sum(offset**2, axis=-1) / deviation**2
    out: Floats = -np.log(2.0 * np.pi * deviation**2) - 0.5 * squared
    return out
