"""The local plan, and the decision that is sent to the wheels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from enum import StrEnum
from types import MappingProxyType
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.reasons import Reason


class Status(StrEnum):
    """Quality of a local plan."""

    OK = "ok"
    """Every constraint holds."""
    RELAXED = "relaxed"
    """A soft constraint is relaxed; see ``slack``. Verified nevertheless."""
    STOP = "stop"
    """Braking: no plan is verified, or the robot stands for a moment after a contact or a stop."""


@value
class LocalPlan:
    """Command and predicted motion of the local planner, with the figures behind its choice."""

    time: float
    """Time of planning, s."""
    step: float
    """Between states, s."""
    command: Annotated[Floats, Shape("3")]
    """Twist for the wheels."""
    poses: Annotated[Floats, Shape("N+1 3")]
    inputs: Annotated[Floats, Shape("N m")]
    """Inputs of the kinematics, (v, ω) for a unicycle."""
    status: Status
    reason: Reason | None = None
    """Given with ``Status.STOP``."""
    brief: bool = False
    """A stop by comfort braking that still rolls: not felt yet, so the rider is not told."""
    urgent: bool = False
    """Comfort braking may not be enough: use the robot's maximum deceleration."""
    costs: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """Cost of each term."""
    smallest_barrier: float = np.inf
    """Minimum h over people and walls along the plan, m; below 0 a social space is entered."""
    slack: float = 0.0
    """Maximum relaxation of a soft constraint, m."""
    iterations: int = 0
    """Quadratic programs solved."""
    candidate: str = ""
    """Name of the chosen candidate trajectory; empty for planners with a single one."""
    disagreement: float = np.nan
    """Angle from the rider's motion to the planner's own choice, rad; NaN without a rider's motion,
    where that is not free, and where the planner stops."""
    memory: Any | None = None
    """Private state of the planner, for its next call."""


@value
class Decision:
    """Twist that is sent to the wheels."""

    twist: Annotated[Floats, Shape("3")]
    reason: Reason | None = None
    """None: the twist that planner or rider requested, unchanged."""
    emergency: bool = False
    """Brake with maximum deceleration; the twist is zero."""
