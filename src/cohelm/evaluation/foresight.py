"""How well it is foreseen where walkers go: predictors on filmed crowds.

Predictions are judged at the moments of the film alone, see ``watched``. Frames of one person
resemble each other, so that intervals come from resampling people, not frames.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.evaluation.bootstrap import LEVEL, RESAMPLES, Estimate
from cohelm.evaluation.watched import Watched
from cohelm.perception import ConstantVelocity, Predictor
from cohelm.recordings.trajectories import Trajectories

AHEAD = 1.2
"""How far ahead a position is foretold, s."""
ALARM = 0.5
"""The probability from which on a hypothesis counts as said."""
AGILITIES = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2)
"""Of which the rival with constant velocity takes the one that suits the crowd best, m²/s³."""
_SAMPLES = 200  # of a mixture, for the region that holds most of it
_SAME = 1e-3  # s


@value
class Foresight:
    """k frames of persons who were seen, and whose position was known ``AHEAD`` later."""

    names: tuple[str, ...]
    """Of the h hypotheses."""
    person: Annotated[Integers, Shape("k")]
    time: Annotated[Floats, Shape("k")]
    """s."""
    weight: Annotated[Floats, Shape("k h")]
    """Probabilities of the hypotheses."""
    density: Annotated[Floats, Shape("k h")]
    """ln of each hypothesis's density where the person came to be, 1/m²."""
    offset: Annotated[Floats, Shape("k h 2")]
    """From where a hypothesis expected the person to where he came, m."""
    deviation: Annotated[Floats, Shape("k h")]
    """m."""
    went_on: Annotated[Booleans, Shape("k")]
    """Whether the person kept going: came within half the way, and at least 0.25 m, of where the
    mean velocity of the last two steps of the film would have led."""

    def log_likelihood(self, weight: Floats | None = None) -> Floats:
        """Log of the mixture's density at the true position, (k,); with ``weight`` (h,) if so."""
        w = self.weight if weight is None else weight
        top = self.density.max(axis=1, keepdims=True)
        out: Floats = top[:, 0] + np.log((w * np.exp(self.density - top)).sum(axis=1))
        return out

    def best_weights(self) -> Floats:
        """(h,), the fixed weights that suit these very frames best, by expectation maximisation."""
        likely = np.exp(self.density - self.density.max(axis=1, keepdims=True))
        weight = np.full(len(self.names), 1.0 / len(self.names))
        for _ in range(300):
            each = weight * likely
            weight = (each / each.sum(axis=1, keepdims=True)).mean(axis=0)
        return weight

    def within(self, share: float = 0.9) -> float:
        """Share of the true positions in the smallest regions that hold ``share`` of the mixtures.

        Such a region is where the density is high; how high, 200 samples of each mixture tell.
        """
        rng = np.random.default_rng(0)
        k, rows = len(self.person), np.arange(len(self.person))
        u = rng.random((_SAMPLES, k, 1))
        picked = np.minimum((u > np.cumsum(self.weight, axis=1)).sum(axis=2), len(self.names) - 1)
        denser = np.zeros(k)
        here = self.log_likelihood()
        for pick in picked:
            noise = self.deviation[rows, pick][:, None] * rng.standard_normal((k, 2))
            # offsets are truth − mean: a sample seen from each hypothesis's mean
            off = noise[:, None] + self.offset - self.offset[rows, pick][:, None]
            there = replace(self, density=_density(off, self.deviation), offset=off)
            denser += there.log_likelihood() > here
        return float(np.mean(denser / _SAMPLES < share))


@value
class Likelihoods:
    """How likely the true position was, ln 1/m², a frame."""

    frames: int
    people: int
    mean: Estimate
    over_fixed: Estimate
    """How much better than the same hypotheses with the fixed weights that suit the crowd best, by
    hindsight."""
    over_usual: Estimate
    """How much better than the same hypotheses with fixed weights that are a best guess: those that
    the predictor gives them on average here."""
    over_constant: Estimate
    """How much better than constant velocity of the agility that suits the crowd best."""
    fixed: Annotated[Floats, Shape("h")]
    """Those weights."""
    agility: float
    """That agility, m²/s³."""
    within_90: float
    """Share of the true positions in the regions that should hold 90 %."""


@value
class Alarms:
    """How often something else than keeping going was said with a probability of ``ALARM``."""

    frames: int
    said: int
    """Frames in which it was, whatever the person did."""
    false: int
    """Those in which the person went on."""

    @property
    def share(self) -> float:
        """False alarms by frames."""
        return self.false / self.frames if self.frames else math.nan


def foresee(
    watched: Watched, predictor: Predictor, *, ahead: float = AHEAD, steps: int = 12
) -> Foresight:
    """What ``predictor`` foretells of the crowd, at the moments of the film."""
    walks, instants = watched.walks, watched.walks.instants
    memory: Any = None
    names: tuple[str, ...] = ()
    found: list[tuple[Any, ...]] = []
    for people, walker in zip(watched.people, watched.walker, strict=True):
        told, memory = predictor.predict(people, steps, ahead / steps, memory)
        names = told.names
        if not len(instants) or np.abs(instants - people.time).min() > _SAME:
            continue
        future, went_on = _future(walks, walker, people.time, ahead)
        for i in np.flatnonzero(np.isfinite(future[:, 0])):
            offset = future[i] - told.mean[i, :, -1]
            found.append(
                (
                    walker[i],
                    people.time,
                    told.weight[i],
                    offset,
                    told.deviation[i, :, -1],
                    went_on[i],
                )
            )
    h = len(names)
    person, time, weight, offset, deviation, went = zip(*found, strict=True) if found else ((),) * 6
    offsets = np.array(offset).reshape(-1, h, 2)
    deviations = np.array(deviation).reshape(-1, h)
    return Foresight(
        names=names,
        person=np.array(person, dtype=np.int64),
        time=np.array(time, dtype=float),
        weight=np.array(weight).reshape(-1, h),
        density=_density(offsets, deviations),
        offset=offsets,
        deviation=deviations,
        went_on=np.array(went, dtype=np.bool_),
    )


def likelihoods(watched: Watched, predictor: Predictor, *, ahead: float = AHEAD) -> Likelihoods:
    """How likely ``predictor`` held the true positions, beside two rivals.

    The rivals are given what they could not know: the weights, and the agility, that suit this very
    crowd best.
    """
    seen = foresee(watched, predictor, ahead=ahead)
    ours, fixed, usual = seen.log_likelihood(), seen.best_weights(), seen.weight.mean(axis=0)
    rivals = [
        foresee(watched, constant_velocity(agility), ahead=ahead).log_likelihood()
        for agility in AGILITIES
    ]
    best = int(np.argmax([rival.mean() for rival in rivals]))
    return Likelihoods(
        frames=len(seen.person),
        people=len(np.unique(seen.person)),
        mean=by_person(ours, seen.person),
        over_fixed=by_person(ours - seen.log_likelihood(fixed), seen.person),
        over_usual=by_person(ours - seen.log_likelihood(usual), seen.person),
        over_constant=by_person(ours - rivals[best], seen.person),
        fixed=fixed,
        agility=AGILITIES[best],
        within_90=seen.within(0.9),
    )


def alarms(seen: Foresight) -> Alarms:
    """How often any hypothesis but the first, keeping going, was said."""
    said = seen.weight[:, 1:].max(axis=1, initial=0.0) >= ALARM
    return Alarms(frames=len(said), said=int(said.sum()), false=int(np.sum(said & seen.went_on)))


def constant_velocity(agility: float) -> ConstantVelocity:
    """The rival, as unsure as it likes."""
    return ConstantVelocity(ConstantVelocity.Parameters(agility=agility, largest_deviation=20.0))


def by_person(values: Floats, person: Integers) -> Estimate:
    """Mean over frames (k,), its interval from resampling the people whose frames they are."""
    who, index = np.unique(person, return_inverse=True)
    if len(who) == 0:
        return Estimate(mean=np.nan, low=np.nan, high=np.nan, count=0)
    total, frames = np.bincount(index, values), np.bincount(index)
    picks = np.random.default_rng(0).integers(len(who), size=(RESAMPLES, len(who)))
    means = total[picks].sum(axis=1) / frames[picks].sum(axis=1)
    low, high = np.quantile(means, [0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0])
    return Estimate(mean=float(values.mean()), low=float(low), high=float(high), count=len(values))


def _future(
    walks: Trajectories, walker: Integers, time: float, ahead: float
) -> tuple[Floats, Booleans]:
    """Where each will be noted ``ahead`` later, (n, 2), NaN where not; and who kept going."""
    future, went_on = np.full((len(walker), 2), np.nan), np.zeros(len(walker), dtype=np.bool_)
    for i in np.flatnonzero(walker >= 0):
        own = slice(walks.first[walker[i]], walks.first[walker[i] + 1])
        times, positions = walks.time[own], walks.position[own]
        now, then = (int(np.abs(times - t).argmin()) for t in (time, time + ahead))
        if max(abs(times[now] - time), abs(times[then] - time - ahead)) > _SAME:
            continue
        future[i] = positions[then]
        before = max(now - 2, 0)
        if before < now:
            usual = (positions[now] - positions[before]) / (times[now] - times[before])
            off = np.hypot(*(positions[then] - positions[now] - ahead * usual))
            went_on[i] = off <= max(0.5 * ahead * np.hypot(*usual), 0.25)
    return future, went_on


def _density(offset: Floats, deviation: Floats) -> Floats:
    """Log of isotropic normal densities, offsets (…, 2)."""
    squared = np.sum(offset**2, axis=-1) / deviation**2
    out: Floats = -np.log(2.0 * np.pi * deviation**2) - 0.5 * squared
    return out
