"""Rate of simulated time on a computer that is too slow for real time.

The safety limits of the navigator hold in simulated time. A navigator that needs longer than
:data:`PROMPT` for an answer therefore slows simulated time down, and the chair in it, before its
answers become too old to drive with; and faster answers let it rise again. The driver's link keeps
real time: heartbeats, STOP.

A real chair cannot slow time down; there the watchdog alone decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

PROMPT = 0.1
"""Latency of an answer up to which time runs at full rate, s: two steps."""
MIN_RATE = 0.1
"""Minimum rate: answers of up to 1 s still drive, and the chair crawls."""
STALL = PROMPT / MIN_RATE
"""Latency beyond which a single answer is a stall, not the speed of the computer, s."""
RISE = 1.0
"""Maximum rise of the rate, 1/s; assumed. A fall takes effect at once, a stop would be worse."""
ABSORBED_LATENESS = 0.05
"""Lateness of a control step that only slows simulated time, s; beyond it STOP would come late."""
_MEAN_TIME = 1.0
"""Time constant of the measured rate, s."""
_SLOW, _FAST = 0.9, 0.97
"""Measured rates at which overload begins and ends."""
_NOTICE_PERIOD = 60.0
"""Minimum time between two notices of overload, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeRate:
    """Rate of simulated time, relative to real time."""

    rate: float = 1.0
    """Rate that the navigator's answers allow."""
    measured: float = 1.0
    """Rate of the last seconds, also below ``rate`` if the control steps are late."""
    advances: bool = True
    """True if the world advances in this step."""
    slow: bool = False
    """True during overload."""
    notice: bool = False
    """True in the step in which overload is to be announced."""
    _stalled: bool = False
    _credit: float = 0.0
    _stepped_at: float = -math.inf
    _answered_at: float = -math.inf
    _noticed_at: float = -math.inf

    def answered(self, latency: float, now: float) -> TimeRate:
        """Return the rate after an answer.

        Args:
            latency: Time from the request to the answer, s.
            now: s.
        """
        stalled = latency > STALL
        if stalled and not self._stalled:
            return replace(self, _stalled=True, _answered_at=now)
        allowed = min(max(PROMPT / max(latency, 1e-3), MIN_RATE), 1.0)
        rise = self.rate + RISE * max(now - self._answered_at, 0.0)
        return replace(self, rate=min(allowed, rise), _stalled=stalled, _answered_at=now)

    def stepped(self, step: float, now: float) -> TimeRate:
        """Return the rate in the next control step.

        Args:
            step: Control period, s.
            now: Time of the step, s.
        """
        elapsed = now - self._stepped_at
        credit = self._credit + self.rate
        advances = credit >= 1.0 - 1e-9
        measured = self.measured
        if math.isfinite(elapsed) and elapsed > 0.0:
            ratio = step * advances / elapsed
            measured += (ratio - measured) * (1.0 - math.exp(-elapsed / _MEAN_TIME))
        slow = measured < (_FAST if self.slow else _SLOW)
        notice = slow and not self.slow and now - self._noticed_at > _NOTICE_PERIOD
        return replace(
            self,
            advances=advances,
            measured=min(measured, 1.0),
            slow=slow,
            notice=notice,
            _credit=credit - advances,
            _stepped_at=now,
            _noticed_at=now if notice else self._noticed_at,
        )

    def resumed(self) -> TimeRate:
        """Return the rate after a time in which the world was not to advance."""
        return replace(self, _stepped_at=-math.inf)
