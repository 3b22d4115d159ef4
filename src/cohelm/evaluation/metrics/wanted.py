"""Arrival as the rider wants it: where, past which places, and over which floor."""

from __future__ import annotations

import numpy as np

from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.geometry import distance_to_polygon, inverse, transform


def as_wanted(ride: Ride) -> bool:
    """Arrived without a collision, past all wanted places, and never on floor to avoid."""
    reached = ride.outcome is Outcome.REACHED
    return reached and places_missed(ride) == 0 and not entered_avoided_floor(ride)


def places_missed(ride: Ride) -> int:
    """Number of wanted places that the chair did not pass, in their order.

    A place is passed where the chair's origin comes within the plan's ``past_distance``.
    """
    plan = ride.scenario.rider_plan
    if plan is None:
        return 0
    at = 0
    for count, place in enumerate(plan.past):
        away = np.hypot(*(ride.pose[at:, :2] - np.array(place)).T)
        near = np.flatnonzero(away <= plan.past_distance)
        if not len(near):
            return len(plan.past) - count
        at += int(near[0])
    return 0


def entered_avoided_floor(ride: Ride) -> bool:
    """Check that the footprint covered the centre of a cell of avoided floor at some tick."""
    split = ride.setup.split if ride.setup is not None else None
    if split is None or not split.avoided.any():
        return False
    cells = ride.world.centres(np.argwhere(split.avoided))
    outline = ride.robot.outline
    reach = float(np.hypot(*outline.T).max())
    for pose in ride.pose:
        near = cells[np.hypot(*(cells - pose[:2]).T) <= reach]
        inside = transform(inverse(pose), near)
        if any(distance_to_polygon(outline, x, y) <= 0.0 for x, y in inside):
            return True
    return False
