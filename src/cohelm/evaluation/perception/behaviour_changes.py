"""Delay until a predictor detects that a simulated pedestrian stops or turns.

A pedestrian walks straight at 0.8 to 1.5 m/s and changes behaviour at a known time:

    stops         decelerates evenly to a stop within 0.5 to 0.8 s
    turns back    reverses the velocity evenly within 0.4 s
    turns aside   turns by 60° to 120°, left or right, evenly within 0.4 to 0.6 s at constant speed

Scans come at 10 Hz with a noise of 3.5 cm on each axis, ticks at 20 Hz, and the time of the change
is independent of both. A change is detected when the predictor gives the hypothesis of its name a
probability of one half or more. The delay is the time from the change, when the velocity begins to
differ, to the first such tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.evaluation.perception.prediction_scores import ALARM
from cohelm.evaluation.perception.tracked_film import detections
from cohelm.messages import Observation, People
from cohelm.perception import KalmanTracker, Predictor, Tracker

SOON = 0.6
"""Accepted delay, s."""
CHANGES = ("stops", "turns_back", "turns_aside_left", "turns_aside_right")
COUNTS = (100, 34, 33, 33)
"""Number of each: a hundred stops, a hundred turns."""
ONSET = 3.0
"""Time before the change, s; at most a tick less."""
_SCANS, _TICKS, _NOISE, _AFTER, _FINE = 10, 20, 0.035, 1.5, 0.01


@value
class BehaviourChange:
    """Pedestrian who changes behaviour, as tracked at each tick."""

    name: str
    """One of ``CHANGES``."""
    onset: float
    """Time of the change, s."""
    people: tuple[People, ...]


@value
class ChangeDelays:
    """Delays until changes were detected."""

    names: tuple[str, ...]
    """Names of the k changes."""
    delay: Annotated[Floats, Shape("k")]
    """Time from the change to its detection, s; +inf: never."""
    early: int
    """Ticks before the change with a false detection."""
    ticks: int
    """Ticks before the change."""

    def share(self, name: str = "") -> float:
        """Share of the changes with a prefix ``name`` that were detected within ``SOON``."""
        selected = np.array([each.startswith(name) for each in self.names], dtype=np.bool_)
        return float(np.mean(self.delay[selected] <= SOON)) if selected.any() else np.nan


def simulated_changes(
    seed: int, counts: Sequence[int] = COUNTS, tracker: Tracker | None = None
) -> tuple[BehaviourChange, ...]:
    """Simulate a number of each of ``CHANGES``; equal for equal seeds."""
    rng = np.random.default_rng(seed)
    tracker = tracker or KalmanTracker()
    names = [name for name, count in zip(CHANGES, counts, strict=True) for _ in range(count)]
    return tuple(_change(name, tracker, rng) for name in names)


def change_delays(changes: Sequence[BehaviourChange], predictor: Predictor) -> ChangeDelays:
    """Measure the delay until ``predictor`` detects each change."""
    delay = np.full(len(changes), np.inf)
    early = ticks = 0
    for k, change in enumerate(changes):
        memory: Any = None
        for people in change.people:
            predictions, memory = predictor.predict(people, 1, 0.1, memory)
            if len(people) == 0:
                continue
            since = people.time - change.onset
            if since < 0.0:
                ticks += 1
                early += int(predictions.weight[:, 1:].max(initial=0.0) >= ALARM)
            elif predictions.probability(change.name).max() >= ALARM:
                delay[k] = since
                break
    return ChangeDelays(
        names=tuple(change.name for change in changes), delay=delay, early=early, ticks=ticks
    )


def walk(name: str, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """(times (k,), positions (k, 2)) of a pedestrian who does ``name`` at ``ONSET``."""
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


def _change(name: str, tracker: Tracker, rng: np.random.Generator) -> BehaviourChange:
    times, positions = walk(name, rng)
    first = rng.uniform(0.0, 1.0 / _SCANS)
    memory: Any = None
    tracked = []
    for k in range(int((times[-1] - first) * _TICKS)):
        now = first + k / _TICKS
        seen = []
        if k % (_TICKS // _SCANS) == 0:
            at = np.array([[np.interp(now, times, axis) for axis in positions.T]])
            seen.append(detections(now, at + _NOISE * rng.standard_normal((1, 2)), _NOISE))
        people, memory = tracker.track(Observation.at_rest(now), tuple(seen), memory)
        tracked.append(people)
    return BehaviourChange(name=name, onset=ONSET, people=tuple(tracked))
