"""Scores of predictors on filmed crowds.

Predictions are scored at the instants of the film only, see ``tracked_film``. Frames of one person
are correlated, so intervals come from resampling people, not frames.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.evaluation.perception.tracked_film import TrackedFilm
from cohelm.evaluation.report.statistics import NO_ESTIMATE, Estimate, bootstrap
from cohelm.perception import ConstantVelocity, Predictor
from cohelm.recordings.pedestrians.trajectories import Trajectories

AHEAD = 1.2
"""Prediction time, s."""
ALARM = 0.5
"""Probability from which a hypothesis counts as predicted."""
AGILITIES = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2)
"""Candidates for the agility of the constant-velocity baseline, m²/s³; it takes the best one."""
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
    continued: Annotated[Booleans, Shape("k")]
    """True where the person continued: within half the distance, and at least 0.25 m, of the
    position extrapolated from the last two steps of the film."""

    def log_likelihood(self, weight: Floats | None = None) -> Floats:
        """Log density of the mixture at the true position, (k,), with weights (h,) if given."""
        w = self.weight if weight is None else weight
        top = self.density.max(axis=1, keepdims=True)
        out: Floats = top[:, 0] + np.log((w * np.exp(self.density - top)).sum(axis=1))
        return out

    def best_weights(self) -> Floats:
        """Fixed weights (h,) with the highest likelihood, by expectation maximisation."""
        likely = np.exp(self.density - self.density.max(axis=1, keepdims=True))
        weight = np.full(len(self.names), 1.0 / len(self.names))
        for _ in range(300):
            each = weight * likely
            weight = (each / each.sum(axis=1, keepdims=True)).mean(axis=0)
        return weight

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


@value
class Likelihoods:
    """Mean log likelihood of the true position per frame, ln 1/m²."""

    frames: int
    people: int
    mean: Estimate
    over_fixed: Estimate
    """Gain over the same hypotheses with the best fixed weights in hindsight."""
    over_mean_weights: Estimate
    """Gain over the same hypotheses with their mean weights."""
    over_constant: Estimate
    """Gain over constant velocity with the best agility."""
    fixed: Annotated[Floats, Shape("h")]
    """Best fixed weights."""
    agility: float
    """Best agility, m²/s³."""
    within_90: float
    """Share of the true positions in the 90 % regions."""


@value
class Alarms:
    """Frames in which a change was predicted with a probability of ``ALARM``."""

    frames: int
    predicted: int
    """Frames with a predicted change."""
    false: int
    """Frames with a predicted change in which the person continued."""

    @property
    def share(self) -> float:
        """False alarms per frame."""
        return self.false / self.frames if self.frames else math.nan


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
        future, continued = _future(walks, walker, people.time, ahead)
        for i in np.flatnonzero(np.isfinite(future[:, 0])):
            offset = future[i] - predictions.mean[i, :, -1]
            found.append(
                (
                    walker[i],
                    people.time,
                    predictions.weight[i],
                    offset,
                    predictions.deviation[i, :, -1],
                    continued[i],
                )
            )
    h = len(names)
    person, time, weight, offset, deviation, went = zip(*found, strict=True) if found else ((),) * 6
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
        continued=np.array(went, dtype=np.bool_),
    )


def likelihoods(watched: TrackedFilm, predictor: Predictor, *, ahead: float = AHEAD) -> Likelihoods:
    """Likelihood of the true positions, compared with baselines.

    The baselines have the weights, and the agility, that are best for this crowd in hindsight.
    """
    seen = predict_film(watched, predictor, ahead=ahead)
    ours, fixed, mean = seen.log_likelihood(), seen.best_weights(), seen.weight.mean(axis=0)
    baselines = [
        predict_film(watched, constant_velocity(agility), ahead=ahead).log_likelihood()
        for agility in AGILITIES
    ]
    best = int(np.argmax([each.mean() for each in baselines]))
    return Likelihoods(
        frames=len(seen.person),
        people=len(np.unique(seen.person)),
        mean=by_person(ours, seen.person),
        over_fixed=by_person(ours - seen.log_likelihood(fixed), seen.person),
        over_mean_weights=by_person(ours - seen.log_likelihood(mean), seen.person),
        over_constant=by_person(ours - baselines[best], seen.person),
        fixed=fixed,
        agility=AGILITIES[best],
        within_90=seen.within(0.9),
    )


def alarms(seen: PredictionSamples) -> Alarms:
    """Count predictions of any hypothesis but the first one, continuing."""
    predicted = seen.weight[:, 1:].max(axis=1, initial=0.0) >= ALARM
    return Alarms(
        frames=len(predicted),
        predicted=int(predicted.sum()),
        false=int(np.sum(predicted & seen.continued)),
    )


def constant_velocity(agility: float) -> ConstantVelocity:
    """Constant-velocity baseline with a large admissible deviation."""
    return ConstantVelocity(ConstantVelocity.Parameters(process_noise=agility, max_deviation=20.0))


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


def _future(
    walks: Trajectories, walker: Integers, time: float, ahead: float
) -> tuple[Floats, Booleans]:
    """Future positions (n, 2), NaN where unknown, and people who continue, (n,)."""
    future, continued = np.full((len(walker), 2), np.nan), np.zeros(len(walker), dtype=np.bool_)
    for i in np.flatnonzero(walker >= 0):
        own = slice(walks.first[walker[i]], walks.first[walker[i] + 1])
        times, positions = walks.time[own], walks.position[own]
        now, then = (int(np.abs(times - t).argmin()) for t in (time, time + ahead))
        if max(abs(times[now] - time), abs(times[then] - time - ahead)) > _SAME:
            continue
        future[i] = positions[then]
        before = max(now - 2, 0)
        if before < now:
            velocity = (positions[now] - positions[before]) / (times[now] - times[before])
            off = np.hypot(*(positions[then] - positions[now] - ahead * velocity))
            continued[i] = off <= max(0.5 * ahead * np.hypot(*velocity), 0.25)
    return future, continued


def _density(offset: Floats, deviation: Floats) -> Floats:
    """Log of isotropic normal densities, offsets (…, 2)."""
    squared = np.sum(offset**2, axis=-1) / deviation**2
    out: Floats = -np.log(2.0 * np.pi * deviation**2) - 0.5 * squared
    return out
