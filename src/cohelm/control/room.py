"""How much room there is to go round who walks: the whole of it about one, shared among many."""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Floats
from cohelm.messages import People
from cohelm.robots.contact import BRISK


def share_of_room(people: People, pose: Floats) -> float:
    """How much of a berth is kept from all who walk, 0…1, without unit.

    Whole where one alone walks, and straight against the robot's heading; less by the cosine the
    more across they walk, and none with it: who crosses is let pass, not gone round. Where they are
    does not matter, so that it does not fade while they are passed. The mean over several is
    divided by their number, as who gives way to one among many by a wide berth would only run into
    the next. In both, slow people count in part, whole from 0.5 m/s on, as the growth of margins
    does. Assumed.

    Args:
        people: as they are now.
        pose: the robot's, (3,), X_MR.
    """
    return float(_share(people.mean, math.cos(pose[2]), math.sin(pose[2])))


@njit(cache=True)
def _share(states: Floats, cos: float, sin: float) -> float:
    """Of states (n, 4), with the robot's heading."""
    walking, towards = 0.0, 0.0
    for i in range(states.shape[0]):
        vx, vy = states[i, 2], states[i, 3]
        speed = math.hypot(vx, vy)
        if speed > 0.0:
            walks = min(speed / BRISK, 1.0)
            walking += walks
            towards += walks * max(-(cos * vx + sin * vy) / speed, 0.0)
    return towards / walking / max(walking, 1.0) if walking > 0.0 else 0.0
