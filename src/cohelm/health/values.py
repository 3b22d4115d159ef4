"""Values of the health monitor: findings, health of the localisation, health of the chair."""

from __future__ import annotations

import math
from dataclasses import field
from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.messages import Reason


class LocalisationState(StrEnum):
    """Trust in the pose."""

    GOOD = "good"
    DOUBTFUL = "doubtful"
    LOST = "lost"
    UNKNOWN = "unknown"
    """No sweep has been compared with the map yet."""


@value
class LocalisationHealth:
    """Fit of sweeps to the map at the reported pose."""

    state: LocalisationState = LocalisationState.UNKNOWN
    contradiction: float = 0.0
    """Smoothed share of informative beams that pass through mapped walls or miss them, 0…1."""
    informative: float = 0.0
    """Share of beams of the last sweep that allow a judgement."""
    offset: Annotated[Floats, Shape("3")] = field(default_factory=lambda: np.zeros(3))
    """Smoothed correction of the pose that would fit better, map frame, m and rad."""
    since: float = -math.inf
    """Time of the last change of state, s."""


@value
class Finding:
    """Contradiction that the monitor has confirmed."""

    reason: Reason
    since: float
    """Time of the confirmation, s."""
    stops: bool
    """True: the chair must stand; False: drive slowly."""
    latched: bool
    """True: it holds until STOP is pressed, because a standing chair cannot disprove it."""


@value
class Health:
    """Judgement of the monitor for one observation."""

    findings: tuple[Finding, ...] = ()
    """Confirmed contradictions, the most serious first."""
    localisation: LocalisationHealth = LocalisationHealth()
    speed_limit: float = math.inf
    """m/s."""
    stop: Reason | None = None
    """Reason to stand; None: the chair may drive."""
    slow: Reason | None = None
    """Reason to drive slowly."""
