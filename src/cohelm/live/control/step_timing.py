"""Times of control steps: with each reading of the leading sensor, else every 0.05 s.

A step at a fixed time would let each scan wait for up to one period. So where a platform has a
leading sensor (``Capabilities.wait``), a step begins when its reading arrives. Without readings the
steps come every 0.05 s all the same: then the navigator notices that the sensor is silent.
"""

from __future__ import annotations

import math
import statistics
import threading
import time
from collections.abc import Callable
from typing import NamedTuple

STEP = 0.05
"""Control period, s."""
ANSWER_TIME = 0.036
"""Part of a step in which an answer is awaited, s; the rest is for the simulated world."""
REAL_ANSWER_TIME = 0.046
"""The same for a real chair."""
MAX_ELAPSED = 2 * STEP
"""Maximum time between two commands that lets the speed rise, s."""
MIN_PERIOD = 0.8 * STEP
"""Minimum time between two steps that begin with readings, s: a fast sensor is not followed."""
PATIENCE = MIN_PERIOD
"""Maximum time for which a step waits beyond its period for a reading that is expected, s. A step
before the reading would make the reading wait for :data:`MIN_PERIOD`."""
_LATE = 0.1 * STEP
"""Jitter of a reading that is expected when a step is due, s; assumed."""
_HISTORY = 9
"""Number of arrivals that tell the sensor's period."""
Wait = Callable[[float, float], float | None]
"""See ``Capabilities.wait``."""


def answer_deadline(due: float, late: float, *, simulated: bool) -> float:
    """Return the time until which a step awaits its answer, s.

    Args:
        due: Time at which the step should have begun, s.
        late: Delay of its beginning, s.
        simulated: The chair is simulated.
    """
    longest = ANSWER_TIME if simulated else REAL_ANSWER_TIME
    return due + longest + (late if late >= STEP else 0.0)  # a lost step gets its full time


def elapsed_time(last: float, now: float) -> float:
    """Return the time since the last command for real wheels, s; at most :data:`MAX_ELAPSED`."""
    return min(max(now - last, 0.0), MAX_ELAPSED)


class Arrivals(NamedTuple):
    """Newest arrivals of the leading sensor's readings, s."""

    times: tuple[float, ...] = ()

    def after(self, time_: float) -> Arrivals:
        """Return the arrivals with one more."""
        return Arrivals((*self.times, time_)[-_HISTORY:])

    @property
    def expected(self) -> float:
        """Time at which the next reading is expected, s; −inf: not known."""
        if len(self.times) < 2:
            return -math.inf
        gaps = [b - a for a, b in zip(self.times, self.times[1:], strict=False)]
        return self.times[-1] + statistics.median(gaps)

    def deadline(self, due: float) -> float:
        """Time at which a step begins without a reading, s.

        A sensor at 10 Hz is expected every second period: between its readings one step begins
        when it is due, and the next one waits a little beyond that.

        Args:
            due: Time one period after the last step, s.
        """
        latest = due + PATIENCE
        return latest if due - STEP < self.expected <= latest else due


class StepTimer:
    """Waits for the next control step.

    Args:
        closing: Ends the waiting for a time; a wait for a reading is short.
    """

    def __init__(self, closing: threading.Event) -> None:
        self._closing, self._arrivals = closing, Arrivals()

    def wait(self, begun: float, wait: Wait | None) -> float:
        """Wait for the next step, and return the time at which it was due, s.

        Args:
            begun: Time at which the last step was due, s.
            wait: Wait of the platform; None: steps come at a fixed period.
        """
        due = begun + STEP
        if wait is None:
            self._sleep_until(due)
            return due
        # A scan that came while the last step was computed begins the next one at once, unless
        # the steps would follow each other too fast.
        earliest = begun + MIN_PERIOD
        self._sleep_until(earliest)
        deadline = self._arrivals.deadline(due)
        at = self._next(wait, -math.inf, deadline)
        if at is not None and at < earliest and self._arrivals.expected <= due + _LATE:
            at = self._next(wait, at, self._arrivals.deadline(due)) or at
        return deadline if at is None else max(at, earliest)

    def _next(self, wait: Wait, after: float, deadline: float) -> float | None:
        """Wait for a reading until the step must begin without one."""
        at = wait(after, max(deadline - time.monotonic(), 0.0))
        if at is not None:
            self._arrivals = self._arrivals.after(at)
        return at

    def _sleep_until(self, end: float) -> None:
        self._closing.wait(max(end - time.monotonic(), 0.0))
