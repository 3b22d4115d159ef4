"""The rider's own motion as a candidate, and how far the planner's own choice deviates from it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.control.candidates import BRAKING, STOPPING, Candidate, PlanningCycle
from cohelm.geometry import wrap_angle

RIDER = "rider"
"""Origin of a candidate that is the rider's own motion, ``LocalPlan.candidate``."""
_COMPARED_AT = 1.5
"""Time at which headings are compared, s."""
_BENDS = (0.0, 0.1, 0.2, 0.35)
"""Angles by which the rider's motion is turned aside if it is not verified, rad."""
_BEND_TIME = 1.0
"""Time of turning aside, s."""
_ON_THE_SPOT = 0.02
"""Speed below which a motion is a turn on the spot, m/s."""
_SPEED_SHARES = (1.0, 0.6, 0.3)
"""Shares of its speed at which the rider's motion is tried if it is not verified."""


def rider_motion(cycle: PlanningCycle) -> Candidate | None:
    """The motion that the rider asks for, within the limits; None without a rider."""
    inputs = cycle.problem.rider_inputs
    if inputs is None:
        return None
    [candidate] = cycle.evaluate([inputs[: cycle.prepared.scene.steps]], [RIDER])
    return candidate


class RiderMotion(NamedTuple):
    """The rider's motion, and what the planner makes of it."""

    used: Candidate | None
    """Verified motion that is nearest to the rider's; None: there is none."""
    free: bool
    """The rider's way is free as far as the planner can tell, perhaps at a lower speed."""


def nearest_to(cycle: PlanningCycle, rider: Candidate) -> RiderMotion:
    """The verified motion that bends the rider's least, and slows it least."""
    if cycle.accepts(rider):
        return RiderMotion(rider, free=True)
    if float(np.abs(rider.inputs[:, :-1]).max()) < _ON_THE_SPOT:
        # A turn on the spot has no slower or bent motion that leads the same way.
        return RiderMotion(None, free=False)
    step = cycle.prepared.scene.step
    for bend in _BENDS if cycle.problem.yields else _BENDS[:1]:
        variants = _variants(rider.inputs, bend, step)
        for candidate in cycle.evaluate(variants, [RIDER] * len(variants)):
            if cycle.accepts(candidate):
                return RiderMotion(candidate, free=bend == 0.0)
    return RiderMotion(None, free=False)


def disagreement(own: Candidate | None, rider: Candidate, step: float) -> float:
    """Angle from the rider's heading to that of the planner's own choice, rad.

    NaN where the planner stops: a stop is no other way.

    Args:
        own: the planner's choice.
        rider: the rider's motion.
        step: time between states, s.
    """
    if own is None or own.origin in {STOPPING, BRAKING}:
        return math.nan
    k = min(round(_COMPARED_AT / step), len(own.poses) - 1, len(rider.poses) - 1)
    return float(wrap_angle(own.poses[k, 2] - rider.poses[k, 2]))


def _variants(inputs: Floats, bend: float, step: float) -> list[Floats]:
    """Inputs (L, m) of the rider's motion turned aside by ``bend``, the fastest first.

    A slower one keeps the curvature. Only its speed is limited, so that it sets off like the
    rider's.
    """
    speed = np.linalg.norm(inputs[:, :-1], axis=1, keepdims=True)
    turning = max(round(_BEND_TIME / step), 1)
    out = []
    for share in _SPEED_SHARES:
        limit = share * float(speed.max())
        slower = inputs * (np.minimum(speed, limit) / np.maximum(speed, 1e-9))
        for side in (1.0, -1.0) if bend else (0.0,):
            bent = slower.copy()
            bent[:turning, -1] += side * bend / (turning * step)
            out.append(bent)
    return out
