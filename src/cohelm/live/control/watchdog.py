"""Latch of the navigator's last decision, and the limit on acceleration: last before the wheels.

Both run in the control thread and need neither the navigator's process nor its answer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.live.control.ipc import StepAnswer
from cohelm.messages import Decision
from cohelm.reasons import Reason
from cohelm.safety import stop

MAX_ANSWER_AGE = 0.15
"""Time for which a decision stays at the wheels, s of ``LiveWorld.time``; then the chair stops."""
MAX_ANSWER_LATENCY = 0.15
"""Maximum time from a request to its answer, s of simulated time; the decision of a later answer is
not used."""
CONFIRM_AFTER = 5.0
"""Silence of the navigator after which the driver must confirm, s; assumed. A shorter stop, as of a
busy computer, ends by itself."""
CONFIRM_REAL_AFTER = 1.0
"""The same for a real chair, whose time does not slow down, s."""
_ROUNDING = 1e-6

INPUT_FAULTS = frozenset(
    {
        Reason.NOT_FINITE,
        Reason.CLOCK,
        Reason.POSE_JUMP,
        Reason.STALE_POSE,
        Reason.STALE_TWIST,
        Reason.STALE_SCAN,
    }
)
"""Reasons after which a real chair waits for its driver's confirmation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Watchdog:
    """Last decision of the navigator with its arrival time; too old a decision becomes a stop."""

    decision: Decision | None = None
    """None: no decision yet."""
    heartbeat_seq: int = -1
    """``Heartbeat.seq`` that it is based on; −1: none."""
    at: float = -math.inf
    """Arrival time, s of a monotonic clock."""
    time: float = -math.inf
    """Arrival time, s of the simulation."""
    epoch: int = 0
    """``LinkState.epoch`` at the time of the request."""

    @classmethod
    def of(cls, answer: StepAnswer, at: float, time: float, epoch: int) -> Watchdog:
        """Return the watchdog after an answer; arguments as the fields."""
        seq = answer.heartbeat_seq
        return cls(decision=answer.decision, heartbeat_seq=seq, at=at, time=time, epoch=epoch)

    def expired(self, time: float) -> bool:
        """Check that the last decision is too old to be used at a time of the simulation, s."""
        return self.decision is None or not time - self.time <= MAX_ANSWER_AGE + _ROUNDING

    def silent(self, now: float, *, simulated: bool) -> bool:
        """Check that the driver must confirm, because the navigator has been silent for too long.

        Args:
            now: s of a monotonic clock.
            simulated: the chair is simulated.
        """
        longest = CONFIRM_AFTER if simulated else CONFIRM_REAL_AFTER
        return self.decision is None or now - self.at > longest

    def select_command(self, time: float, hold_reason: Reason | None) -> Decision:
        """Return the decision for the wheels: the navigator's, or a stop.

        Args:
            time: s of the simulation.
            hold_reason: Reason for a stop whatever the navigator decides; None: there is none.
        """
        if hold_reason is not None:
            return stop(hold_reason)
        if self.decision is None or self.expired(time):
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
        dt: Time since the last command, s.
    """
    velocity, last_velocity = decision.twist[:2], before[:2]
    speed = math.hypot(*velocity)
    # A reversal starts from standing.
    last_speed = math.hypot(*last_velocity) if float(velocity @ last_velocity) >= 0.0 else 0.0
    max_speed = last_speed + max_acceleration * dt
    if decision.emergency or speed <= max_speed:
        return decision
    return replace(decision, twist=decision.twist * (max_speed / speed))
