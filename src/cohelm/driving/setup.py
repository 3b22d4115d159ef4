"""What a live ride is set up with."""

from __future__ import annotations

from pathlib import Path

from cohelm.arrays import value
from cohelm.driving.messages import Limits, RiderSettings
from cohelm.evaluation import Scenario

PACES = {"slow": 0.4, "normal": 0.7, "brisk": 1.0}
"""Speeds that the rider chooses from, m/s; assumed. Limits and robot bound them."""


@value
class DriveSetup:
    """A scenario to drive in, and what is kept of it."""

    scenario: Scenario
    """Floor, people, chair and parts; its goal and wishes are not taken over: the rider says."""
    seed: int = 0
    """Of all chance in the world, ≥ 0."""
    folder: Path | None = None
    """Where sessions, limits and the audit log are kept; None: nothing is."""
    record: Path | None = None
    """An MCAP file to record every tick to; must not exist."""
    limits: Limits | None = None
    """In force at first; None: those that are kept, else what the robot can do."""
    rider: RiderSettings | None = None
    """The same of the rider's settings."""
