"""What goes to the wheels: the newest decision, unless something holds the chair.

Three things stand before the wheels, and none of them asks the navigator: the link, the watchdog of
the navigator, and the therapist's limit on how fast speed may rise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import Decision
from cohelm.reasons import Reason
from cohelm.safety import stop

PATIENCE = 0.15
"""Without a new decision for longer, the chair stands, s."""
FORGETFUL = 1.0
"""A navigator that was silent for longer does not simply go on: the driver confirms, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """The watchdog: what the navigator said last, and when."""

    decision: Decision | None = None
    """None: nothing yet."""
    heard: int = -1
    """The beat that it heeds."""
    at: float = -math.inf
    """When it came, s of a steady clock."""
    turn: int = 0
    """``LinkState.turn`` in which it was asked for."""

    def told(self, decision: Decision, heard: int, at: float, turn: int = 0) -> Watch:
        """A decision has come."""
        return replace(self, decision=decision, heard=heard, at=at, turn=turn)

    def silent(self, now: float) -> bool:
        """Whether the last decision is too old to be driven by."""
        return self.decision is None or not now - self.at <= PATIENCE

    def order(self, now: float, hold: Reason | None) -> Decision:
        """What the wheels are to do.

        Args:
            now: s.
            hold: what makes the chair stand whatever the navigator says; None: nothing.
        """
        if hold is not None:
            return stop(hold)
        if self.decision is None or self.silent(now):
            return stop(Reason.NAVIGATOR_SILENT)
        if not np.isfinite(self.decision.twist).all():
            return stop(Reason.NOT_FINITE)
        return self.decision


def gently(wanted: Decision, before: Floats, max_acceleration: float, dt: float) -> Decision:
    """``wanted`` with a speed that rises no faster than allowed; braking is never limited.

    The whole twist is scaled, so that the chair stays on the curve that was looked at.

    Args:
        wanted: what the navigator decided.
        before: twist (3,) at the wheels until now.
        max_acceleration: m/s².
        dt: until the next decision, s.
    """
    now, then = wanted.twist[:2], before[:2]
    speed = math.hypot(*now)
    last = math.hypot(*then) if float(now @ then) >= 0.0 else 0.0  # to turn back it stands first
    most = last + max_acceleration * dt
    if wanted.emergency or speed <= most:
        return wanted
    return replace(wanted, twist=wanted.twist * (most / speed))
