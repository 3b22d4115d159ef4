"""Angle from the motion that the rider asks for to the planner's own choice."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.control.candidates import BRAKING, STOPPING, Candidate, PlanningCycle
from cohelm.geometry import wrap_angle

RIDER = "rider"
"""Origin of a candidate that is the rider's own motion."""
_COMPARED_AT = 1.5
"""Time at which headings are compared, s."""
_ON_THE_SPOT = 0.02
"""Speed below which a motion is a turn on the spot, m/s."""
_SPEED_SHARES = (1.0, 0.6, 0.3)
"""Shares of its speed at which the rider's motion is verified."""


def disagreement(cycle: PlanningCycle, own: Candidate) -> float:
    """Angle from the rider's heading to that of the planner's own choice, rad.

    NaN without a rider's motion, and where it is not free: such a rider is led for a reason that
    the planner knows. NaN also where the planner stops: a stop is no other way.

    Args:
        cycle: with ``rider_inputs`` in its problem.
        own: the planner's choice.
    """
    inputs = cycle.problem.rider_inputs
    if inputs is None or own.origin in {STOPPING, BRAKING}:
        return math.nan
    [rider] = cycle.evaluate([inputs[: cycle.prepared.scene.steps]], [RIDER])
    if not _is_free(cycle, rider):
        return math.nan
    step = cycle.prepared.scene.step
    k = min(round(_COMPARED_AT / step), len(own.poses) - 1, len(rider.poses) - 1)
    return float(wrap_angle(own.poses[k, 2] - rider.poses[k, 2]))


def _is_free(cycle: PlanningCycle, rider: Candidate) -> bool:
    """Check that the rider's motion is verified, perhaps at a lower speed.

    Like every candidate it is slowed before walls, so that a push straight at a near wall counts as
    free. A rider who approaches a wall obliquely must not lose their way for that.
    """
    if cycle.accepts(rider):
        return True
    if float(np.abs(rider.inputs[:, :-1]).max()) < _ON_THE_SPOT:
        # A turn on the spot has no slower motion that leads the same way.
        return False
    slower = _slower(rider.inputs)
    return any(map(cycle.accepts, cycle.evaluate(slower, [RIDER] * len(slower))))


def _slower(inputs: Floats) -> list[Floats]:
    """Inputs (L, m) of slower motions along the same curve.

    Only the speed is limited, so that they set off like the rider's.
    """
    speed = np.linalg.norm(inputs[:, :-1], axis=1, keepdims=True)
    limits = [share * float(speed.max()) for share in _SPEED_SHARES]
    return [inputs * (np.minimum(speed, each) / np.maximum(speed, 1e-9)) for each in limits]
