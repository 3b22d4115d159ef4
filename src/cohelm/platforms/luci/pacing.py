"""Pace of the remote joystick: 20 messages a second whatever the control loop does; no clock.

a new command           sent at once
no new one for 54 ms    the last one again, every 50 ms: below 10 Hz LUCI applies the brakes
none for MAX_AGE        a centred joystick, every 50 ms
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cohelm.arrays import Floats

MAX_AGE = 0.15
"""Age from which a command counts as lost, s."""
PERIOD = 0.05
"""Time between two messages, s."""
_PATIENCE = 0.054
"""Time for which the next command is awaited before the last one is repeated, s."""
_LEAST = 0.046
"""Minimum time between two messages, s."""


class TimedTwist(NamedTuple):
    """Command of the control loop."""

    made_at: float
    """Monotonic time, s."""
    twist: Floats


class Pacer:
    """Newest command, and the time of the next message.

    Args:
        now: Monotonic time, s.
    """

    def __init__(self, now: float) -> None:
        self._command: TimedTwist | None = None
        self._fresh, self._sent_at, self._due = False, -math.inf, now

    def take(self, command: TimedTwist) -> None:
        """Take a command."""
        self._command, self._fresh = command, True

    def timeout(self, now: float) -> float:
        """Time until a message may be due, s."""
        due = self._sent_at + _LEAST if self._fresh else self._due
        return max(min(due, self._due) - now, 0.0)

    def next(self, now: float) -> tuple[bool, Floats | None]:
        """Return True if a message is due, and its twist; None is a centred joystick."""
        fresh = self._fresh and now - self._sent_at >= _LEAST - 1e-9
        if not fresh and now < self._due:
            return False, None
        command, self._fresh, self._sent_at = self._command, False, now
        self._due = now + (_PATIENCE if fresh else PERIOD)
        if command is None or not 0.0 <= now - command.made_at <= MAX_AGE:
            return True, None
        return True, command.twist
