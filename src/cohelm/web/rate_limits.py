"""Rate limits of a page's messages."""

from __future__ import annotations

HEARTBEATS = 60.0
"""A second; a page sends ten, and one at every change."""
MESSAGES = 100.0
"""A second, beats included."""


class RateLimit:
    """Takes ``rate`` a second in the long run, and ``rate`` at once after a second of none.

    ``now``: any steady clock, s; the same one in every call.
    """

    def __init__(self, rate: float, now: float) -> None:
        self._rate = rate
        self._left = rate
        self._at = now

    def take(self, now: float) -> bool:
        """Check that one more is allowed now, and count it."""
        self._left = min(self._rate, self._left + (now - self._at) * self._rate)
        self._at = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class FaultLimit:
    """Counts what is malformed: a few may happen, many are an attack.

    Forgives ten a minute.
    """

    MAX = 10
    """At once."""

    def __init__(self, now: float) -> None:
        self._left = float(self.MAX)
        self._at = now

    def add(self, now: float) -> bool:
        """One more; returns whether that is still forgiven."""
        self._left = min(float(self.MAX), self._left + (now - self._at) / 6.0)
        self._at = now
        self._left -= 1.0
        return self._left >= 0.0
