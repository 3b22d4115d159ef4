"""Doors that somebody shuts and opens while the world goes on; see ``changes`` for timed ones."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.geometry import transform
from cohelm.maps import OCCUPIED, OccupancyGrid

REACTION = 0.2
"""For which a chair goes on before it brakes, s: a door does not shut in front of it either."""
_APART = 0.1
"""Between the places that a braking chair is looked for at, m."""


@value
class Doorway:
    """An opening in a wall with a door that can be shut."""

    a: Annotated[Floats, Shape("2")]
    """One end of the leaf, m."""
    b: Annotated[Floats, Shape("2")]
    """The other, m."""
    depth: float
    """Of the leaf, m."""


@lru_cache(maxsize=16)
def with_shut(grid: OccupancyGrid, doors: tuple[Doorway, ...]) -> OccupancyGrid:
    """The grid with doors shut in it: the same again for the same grid and doors.

    Args:
        grid: compared by identity, as the doors are; none of them ever changes.
        doors: those that are shut.
    """
    if not doors:
        return grid
    data = grid.data.copy()
    for door in doors:
        length = float(np.hypot(*(door.b - door.a)))
        ahead = (door.b - door.a) / length
        aside = np.array([-ahead[1], ahead[0]])
        half = np.array([(length + grid.resolution) / 2, max(door.depth / 2, grid.resolution)])
        middle = (door.a + door.b) / 2.0
        row, col = grid.cells(middle)
        reach = int(np.ceil(np.hypot(*half) / grid.resolution)) + 1
        rows = np.arange(max(row - reach, 0), min(row + reach + 1, grid.shape[0]))
        cols = np.arange(max(col - reach, 0), min(col + reach + 1, grid.shape[1]))
        cells = np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1).reshape(-1, 2)
        away = grid.centres(cells) - middle
        leaf = cells[(np.abs(np.stack([away @ ahead, away @ aside], axis=-1)) <= half).all(axis=-1)]
        data[leaf[:, 0], leaf[:, 1]] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def on_the_way(outline: Floats, pose: Floats, twist: Floats, deceleration: float) -> list[Floats]:
    """The outlines (k, 2) of a chair from where it is to where it could stand, map frame, m.

    Straight on: in the distance that it takes to brake it turns little.

    Args:
        outline: (k, 2) in its own frame.
        pose: (3,).
        twist: (3,), its own frame.
        deceleration: with which it brakes, m/s².
    """
    speed = float(np.hypot(twist[0], twist[1]))
    far = speed * REACTION + speed**2 / (2.0 * deceleration)
    ahead = twist[:2] / max(speed, 1e-9)
    steps = np.linspace(0.0, far, 1 + int(np.ceil(far / _APART)))
    return [transform(pose, outline + step * ahead) for step in steps]
