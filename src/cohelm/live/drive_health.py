"""Condition of a live ride, as its owner and the server see it."""

from __future__ import annotations

from cohelm.arrays import value


@value
class DriveHealth:
    """Condition of the control loop and its processes."""

    ready: bool
    """True if the chair can drive."""
    error: str
    """Reason why it cannot, and will not without a restart; empty: there is none."""
    ticks: int
    """Control steps so far."""
    missed: int
    """Steps that overran their period, since the chair was ready."""
    longest_streak: int
    """Maximum number of consecutive missed steps."""
    stops: int
    """Stops by the watchdog."""
    restarts: int
    """Restarts of the navigator."""
    rate: float = 1.0
    """Speed of simulated time, 1: real time."""
    unstored: str = ""
    """Sentences about what cannot be stored; empty: everything is."""
