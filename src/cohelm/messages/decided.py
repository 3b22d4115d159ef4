"""What the local planner wants, and what goes to the wheels."""

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
    """What a local plan is."""

    OK = "ok"
    """Every constraint holds."""
    RELAXED = "relaxed"
    """Some soft constraint yields; see ``slack``. Verified all the same."""
    STOP = "stop"
    """No verified plan: braking."""


@value
class LocalPlan:
    """What the local planner wants to do next, and everything it knew when it chose."""

    time: float
    """When it was made, s."""
    step: float
    """Between states, s."""
    command: Annotated[Floats, Shape("3")]
    """Twist for the wheels."""
    poses: Annotated[Floats, Shape("N+1 3")]
    inputs: Annotated[Floats, Shape("N m")]
    """In the kinematics' own inputs, (v, ω) for a unicycle."""
    status: Status
    reason: Reason | None = None
    """Given with ``Status.STOP``."""
    urgent: bool = False
    """Ordinary braking may not be enough: brake as hard as the robot can."""
    costs: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """By term."""
    smallest_barrier: float = np.inf
    """Least h over people and walls along the plan, m; below 0 a social space is entered."""
    slack: float = 0.0
    """Largest yielding of a soft constraint, m."""
    iterations: int = 0
    """Quadratic programs solved."""
    candidate: str = ""
    """Which of the planner's own ways this is; empty where it has but one."""
    memory: Any | None = None
    """The planner's own record, for its next call; nobody else reads it."""


@value
class Decision:
    """What goes to the wheels."""

    twist: Annotated[Floats, Shape("3")]
    reason: Reason | None = None
    """None: exactly what the planner or the rider wanted."""
    emergency: bool = False
    """Brake as hard as the chair can; the twist is zero."""
