"""Watchdog of the navigator, and the limit on acceleration: the last step before the wheels.

Link, watchdog and acceleration limit work without the navigator's process.
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
"""Maximum age of a decision, s; then the chair stops."""
CONFIRM_AFTER = 1.0
"""Silence of the navigator after which the driver must confirm, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Watchdog:
    """Newest decision of the navigator, and its time."""

    decision: Decision | None = None
    """None: no decision yet."""
    heartbeat: int = -1
    """Number of the heartbeat that it is based on."""
    at: float = -math.inf
    """Arrival time, s of a monotonic clock."""
    epoch: int = 0
    """``LinkState.epoch`` at the time of the request."""

    def updated(self, decision: Decision, heartbeat: int, at: float, epoch: int = 0) -> Watchdog:
        """Return the watchdog with a new decision."""
        return replace(self, decision=decision, heartbeat=heartbeat, at=at, epoch=epoch)

    def expired(self, now: float) -> bool:
        """Check that the last decision is too old to be used."""
        return self.decision is None or not now - self.at <= PATIENCE

    def order(self, now: float, hold: Reason | None) -> Decision:
        """Return the decision for the wheels.

        Args:
            now: s.
            hold: Reason for a stop whatever the navigator decides; None: there is none.
        """
        if hold is not None:
            return stop(hold)
        if self.decision is None or self.expired(now):
            return stop(Reason.NAVIGATOR_TIMEOUT)
        if not np.isfinite(self.decision.twist).all():
            return stop(Reason.NOT_FINITE)
        return self.decision


def limit_acceleration(
    decision: Decision, before: Floats, max_acceleration: float, dt: float
) -> Decision:
    """Limit the increase of speed; braking is never limited.

    The whole twist is scaled, so that the chair stays on the verified curve.

    Args:
        decision: Decision of the navigator.
        before: Twist (3,) at the wheels until now.
        max_acceleration: m/s².
        dt: Time until the next decision, s.
    """
    now, then = decision.twist[:2], before[:2]
    speed = math.hypot(*now)
    # A reversal starts from standing.
    last = math.hypot(*then) if float(now @ then) >= 0.0 else 0.0
    max_speed = last + max_acceleration * dt
    if decision.emergency or speed <= max_speed:
        return decision
    return replace(decision, twist=decision.twist * (max_speed / speed))
