"""Rate limits of a page's messages."""

from __future__ import annotations

MAX_HEARTBEAT_RATE = 60.0
"""Maximum rate of heartbeats of a page, 1/s; it sends ten a second, and one at every change."""
MAX_MESSAGE_RATE = 100.0
"""Maximum rate of messages of a page, heartbeats included, 1/s."""
MAX_FAULT_RATE = 1.0 / 6.0
"""Maximum rate of malformed messages of a page in the long run, 1/s."""
MAX_FAULTS = 10.0
"""Maximum number of malformed messages at once."""


class RateLimit:
    """Token bucket: ``rate`` a second in the long run, and up to ``burst`` at once.

    Args:
        rate: 1/s.
        now: Time by any monotonic clock, s; the same one in every call.
        burst: None: those of one second.
    """

    def __init__(self, rate: float, now: float, burst: float | None = None) -> None:
        self._rate, self._burst = rate, rate if burst is None else burst
        self._tokens = self._burst
        self._at = now

    def take(self, now: float) -> bool:
        """Check that one more is allowed now, and count it."""
        self._tokens = min(self._burst, self._tokens + (now - self._at) * self._rate)
        self._at = now
        if self._tokens < 1.0:
            return False
        self._tokens -= 1.0
        return True
