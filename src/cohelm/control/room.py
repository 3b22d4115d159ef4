"""How much room there is to go round who walks: the whole of it about one, shared among many."""

from __future__ import annotations

import numpy as np

from cohelm.messages import People
from cohelm.robots.contact import BRISK


def share_of_room(people: People) -> float:
    """1 / the number of those who walk, at most 1, without unit.

    Who gives way to one alone by a wide berth would among many only run into the next. Slow people
    count in part, whole from 0.5 m/s on, so that nothing jumps where somebody stops. Assumed.
    """
    speed = np.hypot(people.mean[:, 2], people.mean[:, 3])
    return 1.0 / max(float(np.minimum(speed / BRISK, 1.0).sum()), 1.0)
