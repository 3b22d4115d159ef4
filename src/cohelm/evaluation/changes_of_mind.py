"""How soon it is noticed that somebody stops or turns: simulated walkers, seen by the tracker.

A walker goes straight at 0.8 to 1.5 m/s and changes his mind at a known moment:

    stops         slows evenly to a stand within 0.5 to 0.8 s
    turns back    reverses his velocity evenly within 0.4 s
    turns aside   turns by 60° to 120°, left or right, evenly within 0.4 to 0.6 s, keeping his speed

Scans come at 10 Hz with a noise of 3.5 cm on each axis, the chair looks at 20 Hz, and the moment of
the change has nothing to do with either. A change is noticed when the predictor gives the
hypothesis of its name a probability of a half or more; the delay is the time from the change, when
the velocity begins to differ, to the first tick at which it does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.evaluation.foresight import ALARM
from cohelm.evaluation.watched import detections
from cohelm.messages import Observation, People
from cohelm.perception import KalmanTracker, Predictor, Tracker

SOON = 0.6
"""The delay that is allowed, s."""
CHANGES = ("stops", "turns_back", "turns_aside_left", "turns_aside_right")
COUNTS = (100, 34, 33, 33)
"""How many of each: a hundred stops, a hundred turns."""
ONSET = 3.0
"""How long a walker goes straight on before, s; at most a tick less."""
_SCANS, _TICKS, _NOISE, _AFTER, _FINE = 10, 20, 0.035, 1.5, 0.01


@value
class Change:
    """A walker who changes his mind, tick by tick as the tracker tells him."""

    name: str
    """One of ``CHANGES``."""
    onset: float
    """When, s."""
    people: tuple[People, ...]


@value
class Noticed:
    """How soon changes were noticed."""

    names: tuple[str, ...]
    """Of the k changes, what was done."""
    delay: Annotated[Floats, Shape("k")]
    """From the change to the tick at which it was known, s; +inf: never."""
    early: int
    """Ticks before the change at which something was said that was not so."""
    ticks: int
    """Ticks before the change."""

    def share(self, name: str = "") -> float:
        """Of the changes whose name begins with ``name``, those noticed within ``SOON``."""
        meant = np.array([each.startswith(name) for each in self.names], dtype=np.bool_)
        return float(np.mean(self.delay[meant] <= SOON)) if meant.any() else np.nan


def changes(
    seed: int, counts: Sequence[int] = COUNTS, tracker: Tracker | None = None
) -> tuple[Change, ...]:
    """Simulated changes, so many of each of ``CHANGES``; the same for the same seed."""
    rng = np.random.default_rng(seed)
    tracker = tracker or KalmanTracker()
    wanted = [name for name, count in zip(CHANGES, counts, strict=True) for _ in range(count)]
    return tuple(_change(name, tracker, rng) for name in wanted)


def noticed(happened: Sequence[Change], predictor: Predictor) -> Noticed:
    """How soon ``predictor`` knows of each change."""
    delay = np.full(len(happened), np.inf)
    early = ticks = 0
    for k, change in enumerate(happened):
        memory: Any = None
        for people in change.people:
            told, memory = predictor.predict(people, 1, 0.1, memory)
            if len(people) == 0:
                continue
            since = people.time - change.onset
            if since < 0.0:
                ticks += 1
                early += int(told.weight[:, 1:].max(initial=0.0) >= ALARM)
            elif told.probability(change.name).max() >= ALARM:
                delay[k] = since
                break
    return Noticed(
        names=tuple(change.name for change in happened), delay=delay, early=early, ticks=ticks
    )


def walk(name: str, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """(times (k,), positions (k, 2)) of somebody who does ``name`` at ``ONSET``."""
    times = np.arange(0.0, ONSET + _AFTER, _FINE)
    speed, course = rng.uniform(0.8, 1.5), rng.uniform(-np.pi, np.pi)
    lasts = {"stops": rng.uniform(0.5, 0.8), "turns_back": 0.4}.get(name, rng.uniform(0.4, 0.6))
    done = np.clip((times - ONSET) / lasts, 0.0, 1.0)
    angle = np.deg2rad(rng.uniform(60.0, 120.0)) * (1.0 if name.endswith("left") else -1.0)
    shrunk = speed * {"stops": 1.0 - done, "turns_back": 1.0 - 2.0 * done}.get(
        name, 1.0 + 0.0 * done
    )
    turned = course + angle * done * name.startswith("turns_aside")
    velocity = shrunk[:, None] * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    return times, np.cumsum(velocity, axis=0) * _FINE


def _change(name: str, tracker: Tracker, rng: np.random.Generator) -> Change:
    times, positions = walk(name, rng)
    first = rng.uniform(0.0, 1.0 / _SCANS)
    memory: Any = None
    told = []
    for k in range(int((times[-1] - first) * _TICKS)):
        now = first + k / _TICKS
        seen = []
        if k % (_TICKS // _SCANS) == 0:
            at = np.array([[np.interp(now, times, axis) for axis in positions.T]])
            seen.append(detections(now, at + _NOISE * rng.standard_normal((1, 2)), _NOISE))
        people, memory = tracker.track(Observation.at_rest(now), tuple(seen), memory)
        told.append(people)
    return Change(name=name, onset=ONSET, people=tuple(told))
