"""Stick against its own history: a deflection that never changes while the chair stands."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.health.parameters import HealthParameters
from cohelm.messages import Mode, Observation, Reason, Request

_STANDS = 0.02
"""m/s and rad/s."""


class StickHistory(NamedTuple):
    """Memory of the check."""

    deflection: tuple[float, float]
    since: float
    """Begin of the time in which neither stick nor chair moved, s."""


def update_stick(
    memory: StickHistory | None, observation: Observation, request: Request, p: HealthParameters
) -> tuple[StickHistory | None, Reason | None]:
    """Check the device of a rider who drives.

    A key is as constant as a broken stick, so that constancy alone is no sign of a fault; a
    rider who holds it against an obstacle for long gets the same advice. A chair with a
    destination drives there with or without the stick, and needs no advice.

    Returns:
        (memory for the next call, symptom or None).
    """
    rider = observation.rider
    has_goal = request.mode is Mode.SHARED and not np.isnan(request.goal).any()
    if rider is None or request.mode is Mode.AUTONOMOUS or has_goal:
        return None, None
    x, y = (float(d) for d in rider.deflection)
    v, _, w = observation.twist.tolist()
    moves = abs(v) > _STANDS or abs(w) > _STANDS
    centred = math.hypot(x, y) <= max(request.profile.dead_zone, 0.05)
    if memory is None or memory.deflection != (x, y) or moves or centred:
        return StickHistory((x, y), observation.time), None
    stuck = observation.time - memory.since >= p.stuck_time
    return memory, Reason.STICK_STUCK if stuck else None
