"""Objects that change during a ride: timed changes of the map, and doors that a person operates."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.geometry import transform
from cohelm.maps import OCCUPIED, OccupancyGrid
from cohelm.simulation.contact import gap_to_people

DOOR_CLEARANCE = 0.1
"""A door does not close while a person or the chair is nearer than this, m."""
REACTION_TIME = 0.2
"""Time before the chair brakes for a closing door, s."""
_SPACING = 0.1
"""Spacing of the checked positions of a braking chair, m."""


@value
class MapChange:
    """True obstacles from a given time on."""

    time: float
    """s."""
    grid: OccupancyGrid


@value
class ManualDoor:
    """A door that can be shut and opened during a ride."""

    a: Annotated[Floats, Shape("2")]
    """One end of the leaf, m."""
    b: Annotated[Floats, Shape("2")]
    """The other end, m."""
    depth: float
    """Thickness of the leaf, m."""


def current_grid(
    changes: tuple[MapChange, ...],
    now: OccupancyGrid,
    time: float,
    outline: Floats,
    bodies: Floats,
) -> OccupancyGrid:
    """Apply the change that is due at ``time``, or keep ``now`` while people are in its way.

    Args:
        changes: in the order of their times.
        now: obstacles until now.
        time: s.
        outline: (k, 2) of the chair's footprint, map frame, m.
        bodies: (n, 3) people as (x, y, radius), map frame, m.
    """
    due = [change.grid for change in changes if change.time <= time + 1e-9]
    if not due or due[-1] is now:
        return now
    return due[-1] if is_clear(due[-1], now, outline, bodies) else now


def is_clear(then: OccupancyGrid, now: OccupancyGrid, outline: Floats, bodies: Floats) -> bool:
    """Check that neither chair nor people are near the cells that become occupied.

    Arguments as for :func:`current_grid`.
    """
    new = np.argwhere(then.occupied() & ~now.occupied())
    if not len(new):
        return True
    centres = now.centres(new)
    radius = np.full(len(new), now.resolution)
    if (gap_to_people(outline, np.zeros(3), centres, radius) < DOOR_CLEARANCE).any():
        return False
    distance = np.hypot(*(centres[:, None] - bodies[None, :, :2]).transpose(2, 0, 1))
    return bool((distance - bodies[:, 2] - now.resolution >= DOOR_CLEARANCE).all())


@lru_cache(maxsize=16)
def with_shut_doors(grid: OccupancyGrid, doors: tuple[ManualDoor, ...]) -> OccupancyGrid:
    """Add shut doors to the grid; cached, so that equal arguments return the same object.

    Args:
        grid: compared by identity, as the doors are; none of them ever changes.
        doors: the shut ones.
    """
    if not doors:
        return grid
    data = grid.data.copy()
    for door in doors:
        length = float(np.hypot(*(door.b - door.a)))
        along = (door.b - door.a) / length
        across = np.array([-along[1], along[0]])
        half = np.array([(length + grid.resolution) / 2, max(door.depth / 2, grid.resolution)])
        middle = (door.a + door.b) / 2.0
        row, col = grid.cells(middle)
        extent = int(np.ceil(np.hypot(*half) / grid.resolution)) + 1
        rows = np.arange(max(row - extent, 0), min(row + extent + 1, grid.shape[0]))
        cols = np.arange(max(col - extent, 0), min(col + extent + 1, grid.shape[1]))
        cells = np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1).reshape(-1, 2)
        offset = grid.centres(cells) - middle
        local = np.stack([offset @ along, offset @ across], axis=-1)
        leaf = cells[(np.abs(local) <= half).all(axis=-1)]
        data[leaf[:, 0], leaf[:, 1]] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def braking_outlines(
    outline: Floats, pose: Floats, twist: Floats, deceleration: float
) -> list[Floats]:
    """Outlines (k, 2) of a chair on its way to a stop, map frame, m.

    Straight on: within its stopping distance the chair turns little.

    Args:
        outline: (k, 2) in its own frame.
        pose: (3,).
        twist: (3,), its own frame.
        deceleration: m/s².
    """
    speed = float(np.hypot(twist[0], twist[1]))
    distance = speed * REACTION_TIME + speed**2 / (2.0 * deceleration)
    direction = twist[:2] / max(speed, 1e-9)
    steps = np.linspace(0.0, distance, 1 + int(np.ceil(distance / _SPACING)))
    return [transform(pose, outline + step * direction) for step in steps]
