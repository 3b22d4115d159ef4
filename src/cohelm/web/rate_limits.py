"""Rate limits of a page's messages."""

from __future__ import annotations

MAX_HEARTBEAT_RATE = 60.0
"""Maximum rate of heartbeats of a page, 1/s; it sends ten a second, and one at every change."""
MAX_MESSAGE_RATE = 100.0
"""Maximum rate of messages of a page, heartbeats included, 1/s."""


class RateLimit:
    """Token bucket: ``rate`` a second in the long run, and up to ``rate`` at once.

    Args:
        rate: 1/s.
        now: Time by any monotonic clock, s; the same one in every call.
    """

    def __init__(self, rate: float, now: float) -> None:
        self._rate = rate
        self._tokens = rate
        self._at = now

    def take(self, now: float) -> bool:
        """Check that one more is allowed now, and count it."""
        self._tokens = min(self._rate, self._tokens + (now - self._at) * self._rate)
        self._at = now
        if self._tokens < 1.0:
            return False
        self._tokens -= 1.0
        return True


class FaultLimit:
    """Token bucket of malformed messages: up to ten at once, and ten a minute in the long run."""

    MAX = 10
    """Maximum number at once."""

    def __init__(self, now: float) -> None:
        self._tokens = float(self.MAX)
        self._at = now

    def add(self, now: float) -> bool:
        """Count one more; returns False if there were too many."""
        self._tokens = min(float(self.MAX), self._tokens + (now - self._at) / 6.0)
        self._at = now
        self._tokens -= 1.0
        return self._tokens >= 0.0
