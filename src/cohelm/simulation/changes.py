"""What stands in the world may change with time: doors close and open."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.maps import OccupancyGrid
from cohelm.simulation.contact import gap_to_people

ROOM = 0.1
"""A door does not close on whoever is nearer to it than this, m."""


@value
class Change:
    """From a time on this is what truly stands there."""

    time: float
    """s."""
    grid: OccupancyGrid


def present(
    changes: tuple[Change, ...],
    now: OccupancyGrid,
    time: float,
    outline: Floats,
    bodies: Floats,
) -> OccupancyGrid:
    """What stands there: what is due at ``time``, or ``now`` as long as someone is in its way.

    Args:
        changes: in the order of their times.
        now: what has stood there until now.
        time: s.
        outline: (k, 2) of the chair's footprint, map frame, m.
        bodies: (n, 3) people as (x, y, radius), map frame, m.
    """
    due = [change.grid for change in changes if change.time <= time + 1e-9]
    if not due or due[-1] is now:
        return now
    return due[-1] if is_clear(due[-1], now, outline, bodies) else now


def is_clear(then: OccupancyGrid, now: OccupancyGrid, outline: Floats, bodies: Floats) -> bool:
    """Whether nobody is near the cells that are to become occupied; see :func:`present`."""
    new = np.argwhere(then.occupied() & ~now.occupied())
    if not len(new):
        return True
    centres = now.centres(new)
    radius = np.full(len(new), now.resolution)
    if (gap_to_people(outline, np.zeros(3), centres, radius) < ROOM).any():
        return False
    apart = np.hypot(*(centres[:, None] - bodies[None, :, :2]).transpose(2, 0, 1))
    return bool((apart - bodies[:, 2] - now.resolution >= ROOM).all())
