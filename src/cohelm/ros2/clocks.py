"""Clock of a platform: seconds since it was opened, in the time of the robot's stamps."""

from __future__ import annotations

import math
import time

MAX_JUMP = 0.1
"""Change of the robot's clock against the monotonic one that is a jump, s."""
SETTLING = 1.0
"""Time after a jump until the new time is used, s: everything is stale until then."""
MAX_SILENCE = 0.5
"""Maximum time without a message of ``/clock``, s."""


class WallClock:
    """Clock of this computer, to which those of the robot's computers are synchronised."""

    def __init__(self) -> None:
        self._offset = time.time() - time.monotonic()
        self._epoch = time.time()
        self._jumped_at: float | None = None
        self.jumps = 0
        """Number of jumps so far."""

    def now(self) -> float:
        """Return the current time, s; it never runs backwards."""
        monotonic = time.monotonic()
        jump = time.time() - monotonic - self._offset
        if abs(jump) <= MAX_JUMP:
            self._jumped_at = None
        elif self._jumped_at is None:
            self._jumped_at = monotonic
            self.jumps += 1
        elif monotonic - self._jumped_at > SETTLING:
            # From now on stamps are read in the new time, whose zero moves with the jump.
            self._offset += jump
            self._epoch += jump
            self._jumped_at = None
        return monotonic + self._offset - self._epoch

    def of(self, stamp: float) -> float:
        """Return the time of a stamp, s."""
        return stamp - self._epoch

    def stamp(self, now: float) -> float:
        """Return the stamp of a time, s."""
        return now + self._epoch


class RobotClock:
    """Clock of a simulator that publishes ``/clock``."""

    def __init__(self) -> None:
        self._epoch: float | None = None
        self._value = self._latest = 0.0
        self._arrival = -float("inf")
        self.jumps = 0
        """Number of jumps backwards, or by more than a second forwards."""

    def take(self, stamp: float) -> None:
        """Take a message of ``/clock``, s."""
        if self._epoch is None:
            self._epoch = stamp
        value = stamp - self._epoch
        if self._arrival > 0.0 and not -1e-9 <= value - self._value <= 1.0:
            self.jumps += 1
        self._value, self._arrival = value, time.monotonic()

    @property
    def silent(self) -> bool:
        """True if ``/clock`` does not come, or comes no longer."""
        return time.monotonic() - self._arrival > MAX_SILENCE

    def now(self) -> float:
        """Return the current time, s; it never runs backwards, and stands without ``/clock``."""
        self._latest = max(self._latest, self._value)
        return self._latest

    def of(self, stamp: float) -> float:
        """Return the time of a stamp, s; NaN before the first message of ``/clock``."""
        return stamp - self._epoch if self._epoch is not None else math.nan

    def stamp(self, now: float) -> float:
        """Return the stamp of a time, s."""
        return now + (self._epoch or 0.0)


Clock = WallClock | RobotClock
