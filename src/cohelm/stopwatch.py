"""Thread CPU time: measured for reports, never used to decide anything."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats


class Stopwatch:
    """Thread CPU time since the start, and by stage, s."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._start = self._last = time.thread_time()

    def lap(self, name: str) -> None:
        """Add the time since the last lap to the stage ``name``."""
        now = time.thread_time()
        self.laps[name] = self.laps.get(name, 0.0) + now - self._last
        self._last = now

    def elapsed(self) -> float:
        """Time since the stopwatch was made, s."""
        return time.thread_time() - self._start


class Timing(NamedTuple):
    """Summary of repeated measurements, ms."""

    median: float
    p99: float
    """99th percentile; of few measurements it is nearly the maximum."""
    maximum: float
    rounds: int

    @staticmethod
    def of(seconds: Sequence[float] | Floats) -> Timing:
        """Summarise times, (k,) s with k ≥ 1."""
        times = 1e3 * np.asarray(seconds, dtype=float)
        median, p99 = np.percentile(times, [50.0, 99.0])
        return Timing(float(median), float(p99), float(times.max()), len(times))


def timed(call: Callable[[], Any], rounds: int, *, warm_up: int = 1) -> Timing:
    """Time ``rounds`` calls after ``warm_up`` calls that are not counted."""
    for _ in range(warm_up):
        call()
    times = []
    for _ in range(rounds):
        watch = Stopwatch()
        call()
        times.append(watch.elapsed())
    return Timing.of(times)
